"""Reads a 3MF file with Python's own zip and XML readers, checks what the specification asks for, says what is in it."""

import re
import sys
import xml.etree.ElementTree as xml
import zipfile

CORE = '{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}'
MATERIAL = '{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}'
RELATION = '{http://schemas.openxmlformats.org/package/2006/relationships}'

package = zipfile.ZipFile(sys.argv[1])
assert package.testzip() is None, 'a checksum is wrong'
types = xml.fromstring(package.read('[Content_Types].xml'))
assert {t.get('Extension') for t in types} == {'rels', 'model'}
relation = xml.fromstring(package.read('_rels/.rels')).find(RELATION + 'Relationship')
model = xml.fromstring(package.read(relation.get('Target').lstrip('/')))
assert model.get('unit') == 'millimeter'
item = model.find(f'{CORE}build/{CORE}item')
mesh_object = model.find(f'{CORE}resources/{CORE}object')
assert item.get('objectid') == mesh_object.get('id')

group = model.find(f'{CORE}resources/{MATERIAL}colorgroup')
colours = [] if group is None else [c.get('color') for c in group]
assert all(re.fullmatch('#[0-9A-F]{6}', c) for c in colours)
vertices = [[float(v.get(k)) for k in 'xyz'] for v in mesh_object.iter(CORE + 'vertex')]
triangles, corner_colour, volume = 0, {}, 0.0
for t in mesh_object.iter(CORE + 'triangle'):
    corners = [int(t.get(k)) for k in ('v1', 'v2', 'v3')]
    assert len(set(corners)) == 3 and all(0 <= c < len(vertices) for c in corners)
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (vertices[c] for c in corners)
    volume += ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
    triangles += 1
    if colours:
        assert t.get('pid') == group.get('id')
        for corner, key in zip(corners, ('p1', 'p2', 'p3')):
            corner_colour[corner] = colours[int(t.get(key))]

print('vertices', len(vertices))
print('triangles', triangles)
print('size', *(format(max(v[k] for v in vertices) - min(v[k] for v in vertices), 'g') for k in range(3)))
print('colours', len(colours))
print('volume', '+' if volume > 0 else '-')
if colours:
    for axis in range(3):
        for sign, name in ((1, '+'), (-1, '-')):
            farthest = max(corner_colour, key=lambda i: sign * vertices[i][axis])
            print('at', name + 'xyz'[axis], corner_colour[farthest])
