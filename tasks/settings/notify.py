"""The tables [[notify]]: who is told of alarms. Secrets stand in the environment, never in the campaign file."""

import re
from typing import Annotated, Final, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from tasks.settings.section import SafeId, Section, problem

VARIABLE: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,127}")


def _name_of_a_variable(name: object) -> object:
    """Refuse what is no name; it is not shown, for it may be the secret itself."""
    if not isinstance(name, str) or not VARIABLE.fullmatch(name):
        raise problem(
            "needs the name of an environment variable, and got something else that is not shown here",
            'write url_env = "TILTWATCH_MAIL_URL" and put the URL into that variable',
        )
    return name


def _some(command: tuple[str, ...]) -> tuple[str, ...]:
    if not command:
        raise problem("names no program", 'write command = ["PROGRAM", "ARGUMENT"]')
    return command


UrlVariable = Annotated[str, BeforeValidator(_name_of_a_variable)]


class Target(Section):
    """Somebody who is told of alarms."""

    id: SafeId = Field(description="name of the target; rules name it in notify")


class EmailTarget(Target):
    """A mailbox."""

    kind: Literal["email"] = Field(description="kind of target: a mailbox")
    url_env: UrlVariable = Field(
        description="environment variable that holds an apprise URL of mail, as mailtos://USER:PASSWORD@HOST?to=..."
    )


class WebhookTarget(Target):
    """A service that takes messages by HTTP, or any other that apprise knows."""

    kind: Literal["webhook"] = Field(description="kind of target: a service that apprise knows")
    url_env: UrlVariable = Field(
        description="environment variable that holds an apprise URL, as jsons://HOST/PATH; json:// and form:// get the"
        " event as fields, too"
    )


class CommandTarget(Target):
    """A program of one's own."""

    kind: Literal["command"] = Field(
        description="kind of target: a program that gets the event as JSON on stdin"
    )
    command: Annotated[
        tuple[Annotated[str, Field(min_length=1, max_length=4000)], ...],
        Field(strict=False),
        AfterValidator(_some),
    ] = Field(
        description="program and its arguments; it is started without a shell, in the folder of the campaign file"
    )
    timeout_s: float = Field(
        default=30.0, gt=0.0, le=3600.0, description="after so long it is ended and counts as failed [s]"
    )


Notify = Annotated[EmailTarget | WebhookTarget | CommandTarget, Field(discriminator="kind")]
"""A target; ``kind`` says of which kind."""
