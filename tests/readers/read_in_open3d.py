"""Reads a mesh with Open3D and says in JSON what it has then: read_in_open3d.py MESH JSON. Exit code 77: no Open3D."""

import json
import sys

try:
    import open3d
except ImportError:
    sys.exit(77)

mesh = open3d.io.read_triangle_mesh(sys.argv[1])
with open(sys.argv[2], 'w', encoding='utf-8') as out:
    json.dump({
        'vertices': [list(map(float, v)) for v in mesh.vertices],
        'colours': [list(map(float, c)) for c in mesh.vertex_colors],
        'triangles': [list(map(int, t)) for t in mesh.triangles],
    }, out)
