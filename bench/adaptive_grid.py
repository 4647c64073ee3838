#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An adaptive grid as VTK's overlapping AMR: adaptive_grid.py OUT.vth [--levels N].

The unit cube in 4 x 4 x 4 blocks of 8 x 8 x 8 cells each; what a sphere about its middle passes through is refined, block by block into
eight, N times (default 3). The one array is smooth, and steep at the sphere. Prints the numbers of blocks and of cells that no finer
one covers. The blocks' files lie in a folder beside OUT.vth."""
import argparse
import math
import os

BLOCK = 8  # cells along an edge
COARSEST = 4  # blocks along an edge
RADIUS = 0.35


def value(x, y, z):
    radius = math.dist((x, y, z), (0.5, 0.5, 0.5))
    return 1 / (1 + math.exp(40 * (radius - RADIUS))) + 0.2 * math.sin(9 * x) * math.cos(7 * y + 5 * z)


def is_refined(place, edge):
    """Whether the sphere passes through a block."""
    nearest = math.dist((0.5,) * 3, [min(max(0.5, at * edge), (at + 1) * edge) for at in place])
    farthest = math.dist((0.5,) * 3, [max((at * edge, (at + 1) * edge), key=lambda end: abs(end - 0.5)) for at in place])
    return nearest < RADIUS < farthest


def write_block(path, place, spacing):
    first = [at * BLOCK for at in place]
    extent = " ".join(f"{at} {at + BLOCK}" for at in first)
    values = (value(*((at + i + 0.5) * spacing for at, i in zip(first, cell)))
              for cell in ((i, j, k) for k in range(BLOCK) for j in range(BLOCK) for i in range(BLOCK)))
    with open(path, "w", encoding="ascii") as file:
        file.write(f'<VTKFile type="ImageData"><ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{spacing} {spacing} {spacing}">'
                   f'<Piece Extent="{extent}"><CellData><DataArray type="Float32" Name="v" format="ascii">'
                   f'{" ".join(f"{v:.6g}" for v in values)}</DataArray></CellData></Piece></ImageData></VTKFile>\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--levels", type=int, default=3)
    options = parser.parse_args()
    folder = os.path.splitext(options.out)[0]
    os.makedirs(folder, exist_ok=True)
    blocks = [(i, j, k) for k in range(COARSEST) for j in range(COARSEST) for i in range(COARSEST)]
    num_blocks, num_cells = 0, 0
    levels = []
    for level in range(options.levels + 1):
        edge = 1 / COARSEST / 2 ** level
        rows, finer = [], []
        for number, place in enumerate(blocks):
            name = f"{level}-{number}.vti"
            write_block(os.path.join(folder, name), place, edge / BLOCK)
            box = " ".join(f"{at * BLOCK} {at * BLOCK + BLOCK - 1}" for at in place)
            rows.append(f'<DataSet index="{number}" amr_box="{box}" file="{os.path.basename(folder)}/{name}"/>')
            num_blocks += 1
            num_cells += BLOCK ** 3
            if level < options.levels and is_refined(place, edge):
                finer += [tuple(2 * at + (octant >> axis & 1) for axis, at in enumerate(place)) for octant in range(8)]
                num_cells -= BLOCK ** 3
        spacing = edge / BLOCK
        levels.append(f'<Block level="{level}" spacing="{spacing} {spacing} {spacing}">\n' + "\n".join(rows) + "\n</Block>\n")
        blocks = finer
    with open(options.out, "w", encoding="ascii") as file:
        file.write('<VTKFile type="vtkOverlappingAMR"><vtkOverlappingAMR origin="0 0 0" grid_description="XYZ">\n' + "".join(levels) +
                   "</vtkOverlappingAMR></VTKFile>\n")
    print(f"{num_blocks} blocks, {num_cells} cells")


if __name__ == "__main__":
    main()
