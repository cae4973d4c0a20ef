import numpy as np
import pytest

from tasks.surface.blocks import BlockSize, blocks_of_cells, common_variance, weigh_blocks
from tasks.surface.cells import SECTORS
from tests.unit.surface.cells_by_hand import N_HEIGHTS, cells_with, patches, white

SIGMA_M = 0.009
"""Of a cell; a block of 3 heights by 3 sectors has a third of it."""


def test_a_block_is_its_cells_in_height_and_around_and_numbers_have_no_gaps() -> None:
    cells = cells_with(white(np.random.default_rng(0), SIGMA_M), SIGMA_M)
    block = blocks_of_cells(cells, BlockSize(3, 3))
    assert len(np.unique(block)) == block.max() + 1 == N_HEIGHTS * SECTORS // 9
    first = block == block[0]
    assert (cells.height[first].max(), cells.sector[first].max(), np.count_nonzero(first)) == (2, 2, 9)


def test_points_that_err_alone_have_nothing_in_common() -> None:
    rng = np.random.default_rng(1)
    found = [weigh_blocks(cells_with(white(rng, SIGMA_M), SIGMA_M), 3, 0) for _ in range(20)]
    # a block is known to 3 mm, 960 of them tell a common part from 0.7 mm on
    assert max(blocks.common_sigma_m for blocks in found) < 0.0012
    assert sum(blocks.n_off for blocks in found) == 0
    alone = [blocks for blocks in found if blocks.common_sigma_m == 0.0]
    assert len(alone) >= 5
    # the efficiency of Tukey's weights at normal noise with a cut of 7 sigmas
    assert np.mean([blocks.share.mean() for blocks in alone]) == pytest.approx(0.99, abs=0.005)


@pytest.mark.parametrize("common_m", [0.004, 0.012])
def test_what_the_points_of_a_block_have_in_common_is_found(common_m: float) -> None:
    rng = np.random.default_rng(2)
    found = [
        weigh_blocks(cells_with(white(rng, SIGMA_M) + patches(rng, common_m, 3, 3), SIGMA_M), 3, 0)
        for _ in range(10)
    ]
    # a standard deviation from 960 blocks: 2.3 %, ten times; robust weights cost little
    assert np.mean([blocks.common_sigma_m for blocks in found]) == pytest.approx(common_m, rel=0.04)
    # a block of 3 mm is worth no more than one that is 3 mm and its own form off
    left = 0.003**2 / (0.003**2 + common_m**2)
    assert np.mean([blocks.share.mean() for blocks in found]) == pytest.approx(left, rel=0.05)


def test_unknowns_of_the_surface_take_their_part_of_the_residuals() -> None:
    cells = cells_with(
        white(np.random.default_rng(3), SIGMA_M) + patches(np.random.default_rng(3), 0.006, 3, 3), SIGMA_M
    )
    few, many = weigh_blocks(cells, 3, 0).common_sigma_m, weigh_blocks(cells, 3, 480).common_sigma_m
    # of half the redundancy the residuals show half of the variance: (s^2 + v) / 0.5 - v
    assert many == pytest.approx(np.sqrt((few**2 + 0.003**2) / 0.5 - 0.003**2), rel=0.03)


def test_a_bracket_off_the_wall_counts_for_nothing_and_leaves_the_rest_alone() -> None:
    wall_m = white(np.random.default_rng(4), SIGMA_M)
    plain = weigh_blocks(cells_with(wall_m, SIGMA_M), 3, 0)
    wall_m[60:66, 9:12] += 0.2
    found = weigh_blocks(cells_with(wall_m, SIGMA_M), 3, 0)
    share = found.share.reshape(N_HEIGHTS, SECTORS)
    assert found.n_off == 2
    assert not share[60:66, 9:12].any()
    assert found.common_sigma_m == pytest.approx(plain.common_sigma_m, abs=0.0005)
    elsewhere = np.ones(share.shape, dtype=bool)
    elsewhere[60:66, 9:12] = False
    assert share[elsewhere].mean() > 0.9


def test_the_common_variance_is_that_of_dersimonian_and_laird() -> None:
    mean, variance = np.array([0.3, -0.1, 0.5, 0.2]), np.array([0.01, 0.02, 0.04, 0.01])
    # weights 100, 50, 25, 100: 9 + 0.5 + 6.25 + 4 = 19.75 over 4, less 4, over 275
    assert common_variance(mean, variance, 1.0) == pytest.approx(15.75 / 275.0, rel=1e-12)


def test_residuals_below_their_noise_have_no_common_variance() -> None:
    assert common_variance(np.full(4, 0.01), np.full(4, 0.01), 1.0) == 0.0
