"""A wanted size on a grid of square cells: given at places, growing gently with the distance from them."""

from __future__ import annotations

from kernel.numeric.compiled import compiled

_DIAGONAL = 1.4142135623730951


@compiled
def spread(wanted, cell, n_x, n_y, growth):
    """Limit the growth from cell to cell, in place: four sweeps in every direction, as for a distance map.

    wanted: (n_x n_y,), cell (i, j) at j n_x + i.
    """
    straight = growth * cell
    slanted = straight * _DIAGONAL
    for sweep in range(4):
        step_j = 1 if sweep % 2 == 0 else -1
        step_i = 1 if sweep < 2 else -1
        for row in range(n_y):
            j = row if step_j > 0 else n_y - 1 - row
            for column in range(n_x):
                i = column if step_i > 0 else n_x - 1 - column
                q = j * n_x + i
                least = wanted[q]
                has_i = 0 <= i - step_i < n_x
                has_j = 0 <= j - step_j < n_y
                if has_i:
                    least = min(least, wanted[q - step_i] + straight)
                if has_j:
                    least = min(least, wanted[q - step_j * n_x] + straight)
                    if has_i:
                        least = min(least, wanted[q - step_j * n_x - step_i] + slanted)
                    if 0 <= i + step_i < n_x:
                        least = min(least, wanted[q - step_j * n_x + step_i] + slanted)
                wanted[q] = least
