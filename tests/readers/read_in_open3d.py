"""Reads a mesh with Open3D and says in JSON what it has then: read_in_open3d.py MESH JSON. Exit code 77: no Open3D."""

import json
import sys

try:
    import numpy
    import open3d
except ImportError:
    sys.exit(77)

mesh = open3d.io.read_triangle_mesh(sys.argv[1])


def texels():
    """sRGB, one a vertex: the texel under its coordinates. It has turned both upside down."""
    picture = numpy.asarray(mesh.textures[mesh.triangle_material_ids[0]])
    height, width = picture.shape[:2]
    of_vertex = {}
    for vertex, (u, v) in zip(numpy.asarray(mesh.triangles).ravel(), mesh.triangle_uvs):
        of_vertex.setdefault(int(vertex), set()).add(tuple(picture[int(v * height), int(u * width)][:3] / 255))
    assert all(len(values) == 1 for values in of_vertex.values()), 'a vertex of two colours'
    return [list(of_vertex[i].pop()) for i in range(len(mesh.vertices))]


with open(sys.argv[2], 'w', encoding='utf-8') as out:
    json.dump({
        'vertices': [list(map(float, v)) for v in mesh.vertices],
        'colours': texels() if len(mesh.triangle_uvs) else [list(map(float, c)) for c in mesh.vertex_colors],
        'triangles': [list(map(int, t)) for t in mesh.triangles],
    }, out)
