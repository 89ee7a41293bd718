"""Small inputs that `scanknit synth` does not make: volumes, range scans, a mesh, parts of recordings. All numbers are
integers or rounded, so that every computer writes the same files."""

import gzip
import math
import shutil
import struct
import zlib

BALL = (40, 36, 32)  # samples along i, j, k
SPACING = (0.5, 0.5, 0.75)  # millimetres
HILLS_SIDE = 121


def random_numbers(seed):
    """Knuth's linear congruential generator (MMIX): 31 bits each."""
    while True:
        seed = (6364136223846793005 * seed + 1442695040888963407) % 2**64
        yield seed >> 33


def ball(dims=BALL, spacing=SPACING):
    """uint16 samples, little endian, that fall from 1000 at the middle by 80 a millimetre, i fastest."""
    samples = []
    for k in range(dims[2]):
        for j in range(dims[1]):
            for i in range(dims[0]):
                off = [(n - (dim - 1) / 2) * step for n, dim, step in zip((i, j, k), dims, spacing)]
                samples.append(max(0, round(1000 - 80 * math.sqrt(sum(x * x for x in off)))))
    return struct.pack(f"<{len(samples)}H", *samples)


def noise(side):
    """uint8 samples without any order: a mesh of all cases that a cell can have."""
    numbers = random_numbers(7)
    return bytes(next(numbers) >> 23 for _ in range(side**3))


def swapped(samples):
    swapped_bytes = bytearray(samples)
    swapped_bytes[0::2], swapped_bytes[1::2] = samples[1::2], samples[0::2]
    return bytes(swapped_bytes)


def write_nrrd(path, samples, dims, spacing, kind="uint16", encoding="raw"):
    directions = " ".join("(" + ",".join(str(step if axis == n else 0) for n in range(3)) + ")"
                          for axis, step in enumerate(spacing))
    header = (f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {dims[0]} {dims[1]} {dims[2]}\nspace directions: {directions}\nspace origin: (-10,20,5)\n"
              f"endian: little\nencoding: {encoding}\n\n")
    path.write_bytes(header.encode() + (gzip.compress(samples, mtime=0) if encoding == "gzip" else samples))


def write_meta_image(path, samples, dims, spacing):
    header = (f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
              f"TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -10 20 5\n"
              f"ElementSpacing = {spacing[0]} {spacing[1]} {spacing[2]}\n"
              f"DimSize = {dims[0]} {dims[1]} {dims[2]}\nElementType = MET_USHORT\nElementDataFile = LOCAL\n")
    path.write_bytes(header.encode() + samples)


def write_nifti(path, samples, dims, spacing):
    header = bytearray(352)  # 348, and four bytes of "no extension"
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *dims, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 512, 16)  # uint16
    struct.pack_into("<4f", header, 76, 1, *spacing)
    struct.pack_into("<2f", header, 108, 352, 1)  # where samples begin; their slope
    header[123] = 2  # millimetres
    struct.pack_into("<h", header, 254, 1)  # the matrix below holds
    struct.pack_into("<12f", header, 280, spacing[0], 0, 0, -10, 0, spacing[1], 0, 20, 0, 0, spacing[2], 5)
    header[344:348] = b"n+1\0"
    path.write_bytes(bytes(header) + samples)


def dicom_element(group, number, kind, value):
    value = value.encode() if isinstance(value, str) else value
    if len(value) % 2:
        value += b"\0" if kind == "UI" else b" "
    size = struct.pack("<HI", 0, len(value)) if kind in ("OB", "OW") else struct.pack("<H", len(value))
    return struct.pack("<HH", group, number) + kind.encode() + size + value


def write_dicom_series(folder, samples, dims, spacing):
    """A CT image in explicit VR, little endian, for each slice."""
    folder.mkdir()
    image, root = "1.2.840.10008.5.1.4.1.1.2", "1.2.826.0.1.3680043.2.1125"
    pixels = 2 * dims[0] * dims[1]
    for k in range(dims[2]):
        uid = f"{root}.1.{k + 1}"
        meta = b"".join(dicom_element(2, *rest) for rest in (
            (1, "OB", b"\0\1"), (2, "UI", image), (3, "UI", uid), (0x10, "UI", "1.2.840.10008.1.2.1"),
            (0x12, "UI", root)))
        data = b"".join(dicom_element(*rest) for rest in (
            (8, 0x16, "UI", image), (8, 0x18, "UI", uid), (8, 0x60, "CS", "CT"), (0x18, 0x50, "DS", str(spacing[2])),
            (0x20, 0xd, "UI", f"{root}.2"), (0x20, 0xe, "UI", f"{root}.3"), (0x20, 0x13, "IS", str(k + 1)),
            (0x20, 0x32, "DS", f"-10\\20\\{5 + k * spacing[2]}"), (0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"),
            (0x28, 2, "US", struct.pack("<H", 1)), (0x28, 4, "CS", "MONOCHROME2"),
            (0x28, 0x10, "US", struct.pack("<H", dims[1])), (0x28, 0x11, "US", struct.pack("<H", dims[0])),
            (0x28, 0x30, "DS", f"{spacing[1]}\\{spacing[0]}"), (0x28, 0x100, "US", struct.pack("<H", 16)),
            (0x28, 0x101, "US", struct.pack("<H", 16)), (0x28, 0x102, "US", struct.pack("<H", 15)),
            (0x28, 0x103, "US", struct.pack("<H", 0)), (0x7fe0, 0x10, "OW", samples[k * pixels:(k + 1) * pixels])))
        group_length = dicom_element(2, 0, "UL", struct.pack("<I", len(meta)))
        (folder / f"{k:03}.dcm").write_bytes(bytes(128) + b"DICM" + group_length + meta + data)


def write_png_stack(folder, samples, dims):
    """Grey pictures of 16 bits."""
    folder.mkdir()
    row = 2 * dims[0]
    for k in range(dims[2]):
        rows = [swapped(samples[(k * dims[1] + j) * row:][:row]) for j in range(dims[1])]
        png = b"\x89PNG\r\n\x1a\n"
        for kind, content in ((b"IHDR", struct.pack(">IIBBBBB", dims[0], dims[1], 16, 0, 0, 0, 0)),
                              (b"IDAT", zlib.compress(b"".join(b"\0" + one for one in rows))), (b"IEND", b"")):
            png += struct.pack(">I", len(content)) + kind + content
            png += struct.pack(">I", zlib.crc32(kind + content))
        (folder / f"{k:03}.png").write_bytes(png)


def hills(first_x_mm):
    """Rows of heights, metres, of a hilly country of which no two places are alike, millimetre by millimetre."""
    numbers = random_numbers(7)

    def between(low, high):
        return low + (high - low) * (next(numbers) / 2**31)

    heights = [[0.0] * HILLS_SIDE for _ in range(HILLS_SIDE)]
    for _ in range(60):
        x0, y0, width, height = between(-20, 240), between(-20, 240), between(6, 20), between(-0.012, 0.012)
        along_x = [math.exp(-((first_x_mm + n - x0) / width) ** 2 / 2) for n in range(HILLS_SIDE)]
        along_y = [math.exp(-((n - y0) / width) ** 2 / 2) for n in range(HILLS_SIDE)]
        for row, of_y in zip(heights, along_y):
            for n, of_x in enumerate(along_x):
                row[n] += height * of_x * of_y
    return heights


def hill_points(first_x_mm, turn_degrees=0, moved=(0, 0, 0)):
    """The points of the country, metres, from `first_x_mm` on, turned about z and moved; micrometres are rounded."""
    cosine, sine = math.cos(math.radians(turn_degrees)), math.sin(math.radians(turn_degrees))
    for y, row in enumerate(hills(first_x_mm)):
        for x, z in enumerate(row):
            x_m, y_m = (first_x_mm + x) / 1000, y / 1000
            turned = (cosine * x_m - sine * y_m, sine * x_m + cosine * y_m, z)
            yield tuple(round(a + b, 6) for a, b in zip(turned, moved))


def write_range_grid(path, points):
    """A Stanford range grid; gzipped by a name that ends so."""
    count = HILLS_SIDE**2
    text = (f"ply\nformat ascii 1.0\nobj_info num_cols {HILLS_SIDE}\nobj_info num_rows {HILLS_SIDE}\n"
            f"element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element range_grid {count}\nproperty list uchar int vertex_indices\nend_header\n")
    text += "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points) + "".join(f"1 {n}\n" for n in range(count))
    path.write_bytes(gzip.compress(text.encode(), mtime=0) if path.suffix == ".gz" else text.encode())


def write_pcd(path, width=80, height=60):
    """An organised cloud: a bent wall before a camera of 70 pixels' focal length."""
    text = (f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {width}\nHEIGHT {height}\n"
            f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {width * height}\nDATA ascii\n")
    for v in range(height):
        for u in range(width):
            z = 1 + ((u - 40) ** 2 + (v - 30) ** 2) / 10000
            text += f"{(u - 39.5) * z / 70:.6f} {(v - 29.5) * z / 70:.6f} {z:.6f}\n"
    path.write_text(text)


def write_octahedron(path):
    path.write_text("v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
                    "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n")


def write_part(whole, part, frames, flip=False):
    """Some frames of a recording of synth's layout, numbered anew; `flip`: in a world turned by 180 degrees about y,
    and moved."""
    for kind in ("depth", "color"):
        (part / kind).mkdir(parents=True)
    shutil.copy(whole / "camera_intrinsic.json", part)
    poses = (whole / "trajectory.log").read_text().splitlines()
    kept = []
    for number, frame in enumerate(frames):
        rows = poses[5 * frame + 1:5 * frame + 5]
        if flip:
            x, y, z, last = ([float(word) for word in row.split()] for row in rows)
            x, z = [-n for n in x], [-n for n in z]
            x[3], z[3] = x[3] + 0.3, z[3] + 0.4
            rows = [" ".join(map(repr, row)) for row in (x, y, z, last)]
        kept += [f"{number} {number} {number + 1}", *rows]
        for kind in ("depth", "color"):
            shutil.copy(whole / kind / f"{frame:06}.png", part / kind / f"{number:06}.png")
    (part / "trajectory.log").write_text("\n".join(kept) + "\n")
