"""Tables to look at and to copy."""

from dashboard.content.sheet import Head, Line, Sheet, Shown, gap

SHEET = Sheet(
    "Results of A_1 & B",
    (Head("scheme", is_number=False), Head("tilt"), Head("share, %")),
    (
        Line((Shown("A/paper"), Shown("0°34′58″"), Shown("−1.5 ± 0.2"))),
        Line((Shown("E|x*"), gap("two centres"), Shown("2"))),
        Line((Shown("F/paper"),), "gone", "no axis: <b>1 & 2</b>"),
    ),
)


def test_markdown_has_a_cell_for_each_column_and_escapes_what_is_not_ours() -> None:
    lines = SHEET.as_markdown().splitlines()
    assert lines[1] == "|---|---:|---:|"
    assert lines[2] == "| A/paper | 0°34′58″ | −1.5 ± 0.2 |"
    assert lines[3] == r"| E\|x\* | -- | 2 |"
    assert lines[4] == r"| F/paper | no axis: \<b\>1 & 2\</b\> |  |"


def test_latex_escapes_every_special_sign() -> None:
    text = SHEET.as_latex()
    assert r"\caption{Results of A\_1 \& B.}" in text
    assert r"A/paper & 0$^\circ$34$'$58$''$ & $-$1.5 $\pm$ 0.2 \\" in text
    assert r"E|x* & {-}{-} & 2 \\" in text
    assert r"F/paper & no axis: \textless{}b\textgreater{}1 \& 2\textless{}/b\textgreater{} &  \\" in text
    assert r"\begin{tabular}{lrr}" in text


def test_text_that_holds_latex_stays_text() -> None:
    sheet = Sheet("x", (Head("a"),), (Line((Shown(r"\input{/etc/passwd} $x$ ~#{}"),)),))
    row = sheet.as_latex().splitlines()[6]
    assert row == r"\textbackslash{}input\{/etc/passwd\} \$x\$ \textasciitilde{}\#\{\} \\"


def test_a_line_break_in_a_name_breaks_no_row() -> None:
    sheet = Sheet("x", (Head("a"),), (Line((Shown("one\ntwo"),)),))
    assert "| one two |" in sheet.as_markdown()
    assert "one two" in sheet.as_latex()
