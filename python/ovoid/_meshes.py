# SPDX-License-Identifier: Apache-2.0
"""Meshes made of arrays. What is hidden, doubled or in pieces is treated as the readers of mesh files do (docs/formats.md)."""
import re

import numpy as np

from . import _arrays, _core
from ._data import Data
from ._errors import InvalidArgument, Unsupported

# meshio's name of a cell: VTK's number, and how many nodes it has; 0: any.
_TYPES = {
    "vertex": (1, 1), "poly_vertex": (2, 0), "line": (3, 2), "poly_line": (4, 0), "triangle": (5, 3), "triangle_strip": (6, 0),
    "polygon": (7, 0), "pixel": (8, 4), "quad": (9, 4), "tetra": (10, 4), "voxel": (11, 8), "hexahedron": (12, 8), "wedge": (13, 6),
    "pyramid": (14, 5), "penta_prism": (15, 10), "hexa_prism": (16, 12), "line3": (21, 3), "triangle6": (22, 6), "quad8": (23, 8),
    "tetra10": (24, 10), "hexahedron20": (25, 20), "wedge15": (26, 15), "pyramid13": (27, 13), "quad9": (28, 9),
    "hexahedron27": (29, 27), "quad6": (30, 6), "wedge12": (31, 12), "wedge18": (32, 18), "hexahedron24": (33, 24),
    "triangle7": (34, 7), "line4": (35, 4), "convex_point_set": (41, 0), "polyhedron": (42, 0),
}
# VTK's names for those of other names.
_VTK_NAMES = {
    "quadratic_edge": "line3", "quadratic_triangle": "triangle6", "quadratic_quad": "quad8", "quadratic_tetra": "tetra10",
    "quadratic_hexahedron": "hexahedron20", "quadratic_wedge": "wedge15", "quadratic_pyramid": "pyramid13", "biquadratic_quad": "quad9",
    "triquadratic_hexahedron": "hexahedron27", "pentagonal_prism": "penta_prism", "hexagonal_prism": "hexa_prism",
}
# Cells of any order, whose nodes are all taken for neighbours.
_CURVED = re.compile(r"((lagrange|bezier)_.*|(line|triangle|quad|tetra|hexahedron|wedge|pyramid)\d+)")
_PIXEL, _ANY = 8, 41
_NUM_NODES = {code: count for code, count in _TYPES.values() if count}

# VTK's bits, the same for nodes and cells where both have them.
GHOSTS = "vtkGhostType"
_DUPLICATE, _HIDDEN_NODE, _REFINED_CELL, _HIDDEN_CELL = 1, 2, 8, 32
_MAX_NODES = 2**32 - 1

# What the library never draws by itself (data/bookkeeping.cpp).
_BOOKKEEPING = {
    "GlobalNodeId", "PedigreeNodeId", "ObjectId", "GlobalElementId", "PedigreeElementId", "GlobalNodeIds", "GlobalCellIds",
    "GlobalPointIds", "PointIds", "CellIds", "SourceElementId", "SourceElementSide", "ElementBlockIds", "FileId", "GlobalIds",
    "PedigreeIds", "ProcessId", "BlockId", "BlockIndex", "node_ids", "element_ids",
}


class Part:
    """A mesh, or a piece or block of one.

    `points` (n, 3) are floats. Cells are `types` (VTK's numbers), `offsets` (one more, from 0) and `connectivity` (uint32), all
    checked, or structured: `dims` nodes along i, j, k. `arrays` hold (name, values, unit, whether they belong to cells).
    `is_surface`: polygons and lines, which fill no volume.
    """

    def __init__(self, points, cells=None, dims=None, is_surface=False):
        self.points = points
        self.types, self.offsets, self.connectivity = cells or (np.empty(0, "u1"), np.zeros(1, "i8"), np.empty(0, "u4"))
        self.dims = dims
        self.is_surface = is_surface
        self.arrays = []
        self.block = ""

    @property
    def num_cells(self):
        return int(np.prod([max(n - 1, 1) for n in self.dims])) if self.dims else len(self.types)

    def num_of(self, is_cell_data):
        return self.num_cells if is_cell_data else len(self.points)


def places_of(points, name="points"):
    """(n, 3) floats of places in space or, with z = 0, in a plane; these are copied."""
    points = _arrays.numbers_of(points, name)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise InvalidArgument(f"{name}: has the shape {points.shape}, expected (n, 3) or (n, 2)")
    if len(points) > _MAX_NODES:
        raise Unsupported(f"{name}: {len(points)} of them, expected at most 2^32 - 1")
    if points.dtype.kind != "f":
        points = points.astype("f8")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points), points.dtype)])
    with np.errstate(over="ignore", invalid="ignore"):
        is_finite = np.isfinite(points.sum())
    if not is_finite and not np.isfinite(points).all():  # a sum may be too large
        i, axis = np.argwhere(~np.isfinite(points))[0]
        raise InvalidArgument(f"{name}[{i}, {axis}] = {points[i, axis]}: expected a finite number")
    return points


def nodes_of(nodes, num_nodes, name):
    """Numbers of nodes as uint32, checked; the memory of 32 bits is shared."""
    if nodes.dtype.kind not in "iu" and nodes.size:
        raise InvalidArgument(f"{name}: holds {nodes.dtype}, expected numbers of nodes: integers")
    if nodes.size and (nodes.min() < 0 or nodes.max() >= num_nodes):
        where = np.argwhere((nodes < 0) | (nodes >= num_nodes))[0]
        place = f"{name}[{', '.join(map(str, where))}]"
        raise InvalidArgument(f"{place} = {nodes[tuple(where)]}: expected the number of a node, 0 to {num_nodes - 1}")
    nodes = np.ascontiguousarray(nodes).reshape(-1)
    return nodes.view("u4") if nodes.dtype in ("i4", "u4") else nodes.astype("u4")


def cells_of_vtk(types, offsets, connectivity, num_nodes, name):
    """The cells of VTK's three arrays, checked. Pixels become quads."""
    types = np.asarray(types, "u1")
    offsets = np.asarray(offsets, "i8")
    connectivity = nodes_of(connectivity, num_nodes, f"{name}: connectivity")
    if len(offsets) != len(types) + 1 or offsets[0] != 0:
        raise InvalidArgument(f"{name}: {len(offsets)} offsets for {len(types)} cells, expected one more, from 0")
    counts = np.diff(offsets)
    if (counts < 0).any():
        c = np.flatnonzero(counts < 0)[0]
        raise InvalidArgument(f"{name}: offsets[{c + 1}] = {offsets[c + 1]}: expected at least {offsets[c]}")
    if offsets[-1] != len(connectivity):
        raise InvalidArgument(f"{name}: the last cell ends at {offsets[-1]} of {len(connectivity)} numbers of nodes")
    needed = np.zeros(256, "i8")
    for code, count in _NUM_NODES.items():
        needed[code] = count
    is_wrong = (needed[types] != 0) & (counts != needed[types]) & (counts != 0)
    if is_wrong.any():
        c = np.flatnonzero(is_wrong)[0]
        raise InvalidArgument(f"{name}: cell {c} has {counts[c]} nodes, its type has {needed[types[c]]}")
    pixels = offsets[:-1][(types == _PIXEL) & (counts == 4)]
    if len(pixels):
        connectivity = connectivity.copy()
        connectivity[pixels + 2], connectivity[pixels + 3] = connectivity[pixels + 3], connectivity[pixels + 2]
    return types, offsets, connectivity


def _type_of(name):
    """VTK's number of a cell and its number of nodes, by either's name or VTK's number."""
    if isinstance(name, (int, np.integer)):
        if not 0 < name < 256:
            raise InvalidArgument(f"cells: {name!r}: expected VTK's number of a kind of cells")
        return int(name), _NUM_NODES.get(int(name), 0)
    if not isinstance(name, str):
        raise InvalidArgument(f"cells: {name!r}: expected the name of a kind of cells, such as 'tetra'")
    key = name.lower()
    key = key[4:] if key.startswith("vtk_") else key
    key = _VTK_NAMES.get(key, re.sub(r"^(polygon|polyhedron)\d+$", r"\1", key))
    if key in _TYPES:
        return _TYPES[key]
    if _CURVED.fullmatch(key):
        return _ANY, 0
    raise InvalidArgument(f"cells: '{name}': unknown kind of cells{_core.did_you_mean(key, [*_TYPES, *_VTK_NAMES])}")


def _uneven_rows(cells, name):
    """Nodes of each cell, where they are lists of their own; those of polyhedra may be lists of faces."""
    rows = []
    for c, cell in enumerate(cells):
        try:
            has_faces = any(np.ndim(node) for node in cell)
            nodes = np.concatenate([np.ravel(face) for face in cell]) if has_faces else np.asarray(cell)
        except TypeError:
            raise InvalidArgument(f"{name}[{c}] = {cell!r}: expected the nodes of a cell") from None
        if nodes.dtype.kind not in "iu":
            raise InvalidArgument(f"{name}[{c}]: holds {nodes.dtype}, expected numbers of nodes: integers")
        rows.append(np.unique(nodes) if has_faces else nodes)
    return rows


def _block_of(name, nodes, num_nodes, order):
    """VTK's number, nodes of each cell and their numbers, of cells of one kind."""
    code, count = _type_of(name)
    where = f"cells['{name}']"
    is_uneven = isinstance(nodes, (list, tuple)) and not count
    if is_uneven or (isinstance(nodes, np.ndarray) and nodes.dtype == object):
        rows = _uneven_rows(nodes, where)
        nodes = np.concatenate(rows) if rows else np.empty(0, "i8")
        return code, np.array([len(row) for row in rows], "i8"), nodes_of(nodes, num_nodes, where)
    nodes = _arrays.numbers_of(nodes, where)
    if nodes.ndim != 2 or nodes.shape[1] != (count or nodes.shape[1]) or not nodes.shape[1]:
        raise InvalidArgument(f"{where}: has the shape {nodes.shape}, expected (n, {count or 'nodes of a cell'})")
    if code == _PIXEL:
        nodes = nodes[:, [0, 1, 3, 2]]
    elif name == "wedge" and order is not None:
        nodes = nodes[:, order]
    return code, np.full(len(nodes), nodes.shape[1], "i8"), nodes_of(nodes, num_nodes, where)


def _blocks(cells):
    """Pairs of kind and nodes, however they are given."""
    try:
        if not isinstance(cells, dict):
            cells = [(one.type, one.data) if hasattr(one, "type") else one for one in cells]
        return [(name, nodes) for name, nodes in (cells.items() if isinstance(cells, dict) else cells)]
    except (TypeError, ValueError):
        kind = type(cells).__name__
        raise InvalidArgument(f"cells: is a {kind}, expected a dict of names to arrays, such as {{'tetra': (n, 4)}}") from None


def _array_of(name, values, count, noun, is_cell_data):
    array = _arrays.numbers_of(values, name)
    if array.ndim < 1 or len(array) != count or not array.size:
        raise InvalidArgument(f"{name}: has the shape {array.shape}, expected one or more for each of {count} {noun}")
    return str(name), array.reshape(count, -1) if array.ndim > 2 else array, _arrays.unit_of(values), is_cell_data


def _of_all_blocks(name, values, blocks):
    """Cell data as one array: of each kind, by its name or in order, or of all cells already."""
    if isinstance(values, dict):
        missing = [kind for kind, _, _ in blocks if kind not in values]
        if missing or len(values) != len(blocks):
            raise InvalidArgument(f"{name}: expected values for each kind of cells: {', '.join(str(kind) for kind, _, _ in blocks)}")
        values = [values[kind] for kind, _, _ in blocks]
    elif not isinstance(values, (list, tuple)) or len(values) != len(blocks) or not all(np.ndim(one) for one in values):
        return values
    values = [_arrays.numbers_of(one, name) for one in values]
    if [len(one) for one in values] != [count for _, count, _ in blocks]:
        raise InvalidArgument(f"{name}: has {[len(one) for one in values]} values, expected {[count for _, count, _ in blocks]}")
    if len({one.shape[1:] for one in values}) != 1:
        raise InvalidArgument(f"{name}: has as many components in each kind of cells only if all have the same shape")
    return values[0] if len(values) == 1 else np.concatenate(values)


def part_of(points, cells, point_data, cell_data, order=None):
    """A part of plain arrays. `order`: of the nodes of wedges, where it is not VTK's."""
    points = places_of(points)
    given = _blocks(cells)
    made = [_block_of(name, nodes, len(points), order) for name, nodes in given]
    kinds = [(name, len(counts), code) for (name, _), (code, counts, _) in zip(given, made)]
    if made:
        counts = np.concatenate([counts for _, counts, _ in made])
        connectivity = made[0][2] if len(made) == 1 else np.concatenate([nodes for _, _, nodes in made])
        types = np.concatenate([np.full(len(counts), code, "u1") for code, counts, _ in made])
        part = Part(points, (types, np.concatenate([[0], np.cumsum(counts)]), connectivity))
    else:
        part = Part(points)
    for word, given in (("point_data", point_data), ("cell_data", cell_data)):
        if not isinstance(given, (dict, type(None))):
            raise InvalidArgument(f"{word}: is a {type(given).__name__}, expected a dict of names to arrays")
    for name, values in (point_data or {}).items():
        part.arrays.append(_array_of(name, values, len(points), "points", False))
    for name, values in (cell_data or {}).items():
        part.arrays.append(_array_of(name, _of_all_blocks(name, values, kinds), part.num_cells, "cells", True))
    return part


def _make_explicit(part):
    """Structured cells become hexahedra, quads, lines or a vertex, by the axes longer than one node."""
    if not part.dims:
        return
    strides = np.cumprod([1, *part.dims[:2]])
    corners = np.zeros(1, "i8")
    for stride in strides[[n > 1 for n in part.dims]]:  # the second row of a quad runs backwards, a layer as the first
        corners = np.concatenate([corners, (corners[::-1] if len(corners) == 2 else corners) + stride])
    i, j, k = (np.arange(max(n - 1, 1)) for n in part.dims)
    first = (i + strides[1] * j[:, np.newaxis] + strides[2] * k[:, np.newaxis, np.newaxis]).reshape(-1, 1)
    part.connectivity = (first + corners).astype("u4").reshape(-1)
    part.types = np.full(len(first), {1: 1, 2: 3, 4: 9, 8: 12}[len(corners)], "u1")
    part.offsets = np.arange(len(first) + 1, dtype="i8") * len(corners)
    part.dims = None


def _keep(part, is_kept, is_cell_data):
    part.arrays = [(name, values[is_kept] if belongs == is_cell_data else values, unit, belongs)
                   for name, values, unit, belongs in part.arrays]
    if not is_cell_data:
        part.points = part.points[is_kept]
        return
    counts = np.diff(part.offsets)
    part.connectivity = part.connectivity[np.repeat(is_kept, counts)]
    part.offsets = np.concatenate([[0], np.cumsum(counts[is_kept])])
    part.types = part.types[is_kept]


def flags_of(arrays, is_cell_data):
    """What says which points or cells are ghosts; None without."""
    for name, values, _, belongs in arrays:
        if name == GHOSTS and belongs == is_cell_data and values.dtype == np.uint8 and values.ndim == 1:
            return values
    return None


def _drop_ghosts(part):
    """Takes out what is hidden or another piece's, and cells without nodes; returns how many."""
    nodes, cells = flags_of(part.arrays, False), flags_of(part.arrays, True)
    has_hidden = nodes is not None and bool((nodes & _HIDDEN_NODE).any())
    is_gone = np.zeros(1, bool) if cells is None else (cells & (_DUPLICATE | _REFINED_CELL | _HIDDEN_CELL)) != 0
    if part.num_cells and (has_hidden or is_gone.any() or (np.diff(part.offsets) == 0).any()):
        _make_explicit(part)
        is_kept = (np.diff(part.offsets) > 0) & ~is_gone
        if has_hidden:
            of_cell = np.repeat(np.arange(part.num_cells), np.diff(part.offsets))
            is_kept[of_cell[(nodes & _HIDDEN_NODE)[part.connectivity] != 0]] = False
        is_about_cells = True
    elif not part.num_cells and nodes is not None:
        is_kept, is_about_cells = (nodes & (_DUPLICATE | _HIDDEN_NODE)) == 0, False
    else:
        is_kept, is_about_cells = np.ones(1, bool), False
    if not is_kept.all():
        _keep(part, is_kept, is_about_cells)
    part.arrays = [array for array in part.arrays if array[0] != GHOSTS]
    return int((~is_kept).sum())


def _key(array):
    name, values, _, is_cell_data = array
    return name, is_cell_data, values.dtype, values.shape[1:]


def _shared_arrays(parts):
    """The arrays that every part has. One without cells has no cell arrays to have."""
    shared = {}
    for array in (array for part in parts for array in part.arrays):
        if all((array[3] and not part.num_cells) or any(_key(own) == _key(array) for own in part.arrays) for part in parts):
            shared.setdefault(_key(array), array)
    return shared


def _chosen_blocks(source, parts, notes):
    names = list(dict.fromkeys(part.block for part in parts))
    if len(names) < 2:
        return parts
    if any(not name.startswith("vtk") and name not in _BOOKKEEPING for name, _, _, _ in _shared_arrays(parts)):
        notes.append(f"{source}: all {len(names)} blocks are taken; one that is given by itself is drawn alone")
        return parts

    def size(name):
        return tuple(sum(part.num_of(is_cell_data) for part in parts if part.block == name) for is_cell_data in (True, False))

    largest = max(names, key=size)
    notes.append(f"{source}: its {len(names)} blocks share no array: the largest, '{largest}', is taken; give another one by itself")
    return [part for part in parts if part.block == largest]


def _merged(source, parts, notes):
    """One mesh of all parts: nodes of different ones at exactly the same place become one."""
    shared = _shared_arrays(parts)
    left_out = dict.fromkeys(array[0] for part in parts for array in part.arrays if _key(array) not in shared)
    notes.extend(f"{source}: array '{name}' is left out: not every piece or block has it with the same type" for name in left_out)
    for part in parts:
        _make_explicit(part)
    points = np.concatenate([part.points for part in parts])
    of_part = np.repeat(np.arange(len(parts)), [len(part.points) for part in parts])
    order = np.lexsort((*(points.T + 0.0),))  # stable; zero has two signs and is one place
    is_first = np.ones(len(points), bool)
    is_first[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    owner = np.empty(len(points), "i8")
    owner[order] = order[is_first][np.cumsum(is_first) - 1]
    is_new = of_part == of_part[owner]  # two nodes of one part may be the two sides of a crack and stay two
    if is_new.sum() > _MAX_NODES:
        raise Unsupported(f"{source}: {is_new.sum()} points in all, expected at most 2^32 - 1")
    number = np.cumsum(is_new) - 1
    number = np.where(is_new, number, number[owner]).astype("u4")
    if not is_new.all():
        notes.append(f"{source}: {(~is_new).sum()} points at places of other pieces are merged")
    begins = np.concatenate([[0], np.cumsum([len(part.points) for part in parts])])
    counts = np.concatenate([np.diff(part.offsets) for part in parts])
    connectivity = np.concatenate([number[begin:][part.connectivity] for begin, part in zip(begins, parts)])
    cells = np.concatenate([part.types for part in parts]), np.concatenate([[0], np.cumsum(counts)]), connectivity
    whole = Part(points[is_new], cells, is_surface=all(part.is_surface for part in parts))
    for key, (name, _, unit, is_cell_data) in shared.items():
        pieces = [next((own[1] for own in part.arrays if _key(own) == key), None) for part in parts]
        values = np.concatenate([piece for piece in pieces if piece is not None])
        whole.arrays.append((name, values if is_cell_data else values[is_new], unit, is_cell_data))
    return whole


_TRIANGLE, _STRIP, _POLYGON = 5, 6, 7


def with_triangles(part):
    """The part with triangles in the place of polygons, which are taken to be convex, and strips."""
    is_strip, counts = part.types == _STRIP, np.diff(part.offsets)
    is_split = is_strip | ((part.types == _POLYGON) & (counts > 2))
    if not is_split.any():
        return part
    num_new = np.where(is_split, np.maximum(counts - 2, 0), 1)
    cell = np.repeat(np.arange(len(counts)), num_new)  # that each new one is of
    number = np.arange(len(cell)) - np.repeat(np.cumsum(num_new) - num_new, num_new)  # within it
    new_counts = np.where(is_split[cell], 3, counts[cell])
    offsets = np.concatenate([[0], np.cumsum(new_counts)])
    corner = np.arange(offsets[-1]) - np.repeat(offsets[:-1], new_counts)
    cell_of, number_of = np.repeat(cell, new_counts), np.repeat(number, new_counts)
    of_strip = np.where(number_of % 2 == 1, np.array([1, 0, 2])[np.minimum(corner, 2)], corner) + number_of
    of_polygon = np.where(corner == 0, 0, corner + number_of)
    place = np.where(is_split[cell_of], np.where(is_strip[cell_of], of_strip, of_polygon), corner)
    types = np.where(is_split, _TRIANGLE, part.types).astype("u1")
    made = Part(part.points, (types[cell], offsets, part.connectivity[part.offsets[:-1][cell_of] + place]), is_surface=part.is_surface)
    made.arrays = [(name, values[cell] if is_cell_data else values, unit, is_cell_data) for name, values, unit, is_cell_data in part.arrays]
    made.block = part.block
    return made


def _make_particles(source, whole, notes):
    """Points with vertices, or with nothing between them. Arrays of vertices that are the points, one for one, become arrays of points."""
    if whole.is_surface and whole.num_cells:
        notes.append(f"{source}: its {whole.num_cells} lines and polygons enclose no volume and are left out: its points are taken")
    is_one_to_one = not whole.is_surface and whole.num_cells == len(whole.points) and \
        np.array_equal(whole.connectivity, np.arange(len(whole.points)))
    kept = []
    for name, values, unit, is_cell_data in whole.arrays:
        if is_cell_data and not is_one_to_one:
            notes.append(f"{source}: array '{name}' is left out: it belongs to cells, points are taken")
        else:
            kept.append((name, values, unit))
    return _core.particles(source, whole.points, kept)


def data_of_parts(source, parts, notes, form, active=None, faces=False):
    """Data of all parts: a mesh, or particles if there are no cells but vertices. `active`: the array that is drawn by itself. `faces`:
    surfaces and lines, with or without values, are meshes, too."""
    parts = [part for part in parts if len(part.points)]
    if not parts:
        raise InvalidArgument(f"{source}: has no points")
    num_dropped, left = 0, []
    for part in parts:
        had_cells, num_gone = part.num_cells > 0, _drop_ghosts(part)
        num_dropped += num_gone
        if not num_gone or part.num_of(had_cells):
            left.append(part)
    if not left:
        raise InvalidArgument(f"{source}: all {num_dropped} cells or points are hidden or duplicates of other pieces'")
    if num_dropped:
        notes.append(f"{source}: {num_dropped} hidden or duplicate cells or points are left out")
    left = _chosen_blocks(source, left, notes)
    whole = left[0] if len(left) == 1 else _merged(source, left, notes)
    if (whole.is_surface and not faces) or (not whole.dims and np.isin(whole.types, (1, 2)).all()):
        core = _make_particles(source, whole, notes)
    elif not whole.arrays and not faces:
        raise InvalidArgument(f"{source}: has no array of numbers at its points or cells")
    else:
        core = _core.mesh(source, whole.points, whole.types, whole.offsets, whole.connectivity, whole.dims or (0, 0, 0), whole.arrays)
    names = core.array_names
    return Data(core.with_facts(form, "none", notes), {"array": active} if active in names and len(names) > 1 else None)


def mesh(points, cells, point_data=None, cell_data=None):
    """Cells between points, with values at either, as data for `render`, or for its settings `add` and `within`, with values or without.

    Parameters
    ----------
    points : array_like, (n, 3) or (n, 2)
        Places of the nodes; world units. Floats (n, 3) in C order are not copied; in a plane z is 0.
    cells : dict of str to array_like, or list of pairs
        For each kind of cells, by meshio's or VTK's name ("tetra", "VTK_TETRA", "hexahedron20", ...) or VTK's number, the nodes of
        each, (cells, nodes of a cell), in VTK's order. Of polygons and polyhedra also lists of any lengths; of polyhedra the faces
        or all nodes. A single array of 32 bits in C order is not copied.
    point_data : dict of str to array_like, (n,) or (n, components), optional
        Values of the nodes, by names of arrays.
    cell_data : dict of str to array_like, optional
        Of each array the values of all cells, kind after kind; or a list or dict of arrays, one for each kind.

    Returns
    -------
    Data

    Raises
    ------
    InvalidArgument
        For kinds of cells that there are not, numbers of nodes that there are not, and shapes that do not fit.

    Examples
    --------
    >>> import numpy, ovoid
    >>> points = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], "f4")
    >>> tetra = numpy.array([[0, 1, 2, 3], [1, 2, 3, 4]], "u4")
    >>> ovoid.mesh(points, {"tetra": tetra}, {"heat": points[:, 2]})
    <ovoid.Data mesh 'mesh', 5 points: heat>
    """
    part = part_of(points, cells, point_data, cell_data)
    if not part.num_cells:
        raise InvalidArgument("cells: there are none; points alone are drawn by ovoid.particles")
    return data_of_parts("mesh", [part], [], "array", faces=True)
