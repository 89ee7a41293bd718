"""Run by Blender: reads a mesh with its importer for the format, says in JSON what is in the scene then.

blender -b --factory-startup --python-exit-code 3 --python read_in_blender.py -- MESH JSON
"""

import json
import sys

import numpy

numpy.bool = bool  # Debian's Blender 3.4 asks for what its NumPy has no more

import bpy

mesh_file, json_file = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
importers = {
    'glb': bpy.ops.import_scene.gltf,
    'ply': bpy.ops.import_mesh.ply,
    'obj': bpy.ops.wm.obj_import,
    'stl': bpy.ops.import_mesh.stl,
}
importers[mesh_file.rsplit('.', 1)[1]](filepath=mesh_file)
found = [thing for thing in bpy.context.scene.objects if thing.type == 'MESH']
assert len(found) == 1, f'{len(found)} meshes'
mesh, to_world = found[0].data, found[0].matrix_world
assert all(len(polygon.vertices) == 3 for polygon in mesh.polygons)


def one_a_vertex(values):
    """Of (vertex, value) pairs, the value of each vertex; it must have one only."""
    of_vertex = {}
    for vertex, value in values:
        of_vertex.setdefault(vertex, set()).add(value)
    assert all(len(values) == 1 for values in of_vertex.values()), 'a vertex of two colours'
    return [list(of_vertex[i].pop()) for i in range(len(mesh.vertices))]


def texture():
    """The picture that the material's base colour comes from; None without one."""
    for material in mesh.materials:
        for shader in (node for node in material.node_tree.nodes if node.type == 'BSDF_PRINCIPLED'):
            for link in shader.inputs['Base Color'].links:
                if link.from_node.type == 'TEX_IMAGE':
                    return link.from_node.image
    return None


def texels(image):
    """sRGB, one a vertex: the texel under its coordinates, whose rows count from below."""
    assert image.colorspace_settings.name == 'sRGB', image.colorspace_settings.name
    width, height = image.size
    pixels, uv = list(image.pixels), mesh.uv_layers.active.data

    def texel(loop):
        at = 4 * (int(uv[loop].uv[1] * height) * width + int(uv[loop].uv[0] * width))
        return tuple(pixels[at:at + 3])

    return one_a_vertex((mesh.loops[i].vertex_index, texel(i)) for i in range(len(mesh.loops)))


def colours():
    """One a vertex: texels where there is a texture, else linear light, as a shader sees them."""
    if texture():
        assert not mesh.color_attributes
        return texels(texture())
    if not mesh.color_attributes:
        return []
    attribute = mesh.color_attributes.active_color or mesh.color_attributes[0]
    if attribute.domain == 'POINT':
        return [list(value.color)[:3] for value in attribute.data]
    return one_a_vertex(
        (loop.vertex_index, tuple(value.color)[:3]) for loop, value in zip(mesh.loops, attribute.data))


with open(json_file, 'w', encoding='utf-8') as out:
    json.dump({
        'vertices': [list(to_world @ vertex.co) for vertex in mesh.vertices],
        'colours': colours(),
        'triangles': [list(polygon.vertices) for polygon in mesh.polygons],
    }, out)
