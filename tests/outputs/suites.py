"""The commands that are run. Each function is a suite that makes its own inputs. Pictures are small and voxels coarse,
so that a command takes a second or less."""

import json
import pathlib
import re
import shutil

import inputs
from recorder import Missing, data_folder, sha256
from ros2_bag import write_ros2_bag

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
SMALL, FULL = "--width 160 --height 120 --quiet", "--width 640 --height 480 --quiet"  # pixels
BARE = " --set export.formats=[ply] --set export.preview=false"


def synth(r):
    """Every scene, and every option of `synth`."""
    inputs.write_octahedron(r.path("octahedron.obj"))
    for scene in ("sphere", "turntable", "tower", "desk", "plates", "room", "gallery", "twins"):
        r.run(scene, f"synth {scene} -o {scene} --frames 3 {SMALL}")
    r.run("noise", f"synth desk -o noise --frames 4 --noise --seed 3 {SMALL}")
    r.run("jpeg", f"synth room -o jpeg --frames 4 --noise --seed 9 --jpeg {SMALL}")
    for scene in ("clutter", "corridor", "bare_wall", "hall"):
        r.run(scene, f"synth {scene} -o {scene} --frames 3 {SMALL}")
    for sensor in ("ideal", "kinect1", "d435", "phone_lidar"):
        r.run(sensor, f"synth clutter -o {sensor} --frames 3 --sensor {sensor} --path turns --person sitting {SMALL}")
    r.run("mesh", f"synth octahedron.obj -o mesh --size 20cm --frames 4 {SMALL}")
    r.run("turned", f"synth tower -o turned --turntable --angle-noise 0.5 --hand --noise --frames 12 {SMALL}")
    r.run("on_side", f"synth tower -o on_side --turntable --on-side --turns 0.7 --jpeg --frames 4 {SMALL}")
    r.run("masked", f"synth octahedron.obj -o masked --size 20cm --frames 12 --masks {SMALL}")
    r.run("hull", "run masked -o hull --geometry silhouettes --quiet" + BARE)
    r.run("list", "synth --list", said="bytes")


def scan(r, name, scene, size=SMALL):
    """A recording to work on; the suite `synth` compares such recordings themselves."""
    done = r.call(f"synth {scene} -o {name} {size}".split())
    if done.returncode:
        raise RuntimeError(done.stderr.decode())


def presets(r):
    """`run` with every preset."""
    scan(r, "turntable", "turntable --frames 24 --noise")
    scan(r, "room", "room --frames 24")
    scan(r, "full", "desk --frames 3", size=FULL)
    scan(r, "desk", "desk --frames 24 --noise")
    places = {"room": ("room", "large", "phone_lidar", "kinect_v1", "realsense_d400"),
              "full": ("tum_freiburg1", "tum_freiburg2", "tum_freiburg3", "icl_nuim"),
              "desk": ("object", "print", "head")}
    voxels = {"room": "6cm", "full": "6cm", "desk": "1cm", "turntable": "8mm"}
    recorded = "--set acquire.depth_scale=auto"  # some presets state that of their cameras
    for preset in sorted(path.stem for path in CONFIGS.glob("*.yaml")):
        place = next((place for place, used in places.items() if preset in used), "turntable")
        scanned_as = "--preset object --preset print" if preset == "print" else f"--preset {preset}"
        voxel = f"--set fusion.voxel_size={voxels[place]}"
        r.run(preset, f"run {place} -o {preset} {scanned_as} {voxel} {recorded} --quiet")
        printed = r.run(f"{preset}_config", f"config print --preset {preset}", said="text")
        r.keep("bytes", f"{preset}_config/keys", sha256(keys_of(printed)))
    for preset in ("object", "print", "room"):
        r.page(preset)


def keys_of(yaml):
    """A configuration without its comments."""
    return "\n".join(line for line in (re.sub(r"(^|\s)#.*", "", line).rstrip() for line in yaml.splitlines()) if line)


def run(r):
    """`run` with its options and keys, except finishing and formats."""
    scan(r, "desk", "desk --frames 90 --noise --seed 3 --jpeg")
    coarse = "--set fusion.voxel_size=2cm --quiet"
    r.run("plain", f"run desk -o plain --every 4 {coarse} --save-volume plain.vdb --json", said="json")
    r.page("plain")
    for poses in ("recording", "track", "refine", "still"):
        r.run(poses, f"run desk -o {poses} --to 24 --poses {poses} {coarse}")
        r.page(poses)
    r.run("lost", f"run desk -o lost --every 9 --poses track {coarse} --save-volume lost.vdb", said="error")
    r.page("lost")
    coarse += BARE
    r.run("files", f"run desk -o files.ply --from 3 --to 20 --every 2 {coarse} --report files.json "
                   "--trajectory files.txt --save-volume files.vdb")
    r.run("stepped", f"run desk -o stepped.ply --to 7 --pace stepped {coarse}", stdin="\n" * 8)
    filters = "acquire.bilateral=true acquire.outlier_neighbours=12 acquire.edge_sigmas=0 acquire.min_depth=0.5"
    r.run("filters", f"run desk -o filters --to 7 {sets(filters)} {coarse}")
    fusion = "fusion.truncation=6 fusion.truncation_sigmas=0 fusion.max_weight=3 fusion.carve_free_space=false"
    r.run("fusion", f"run desk -o fusion --to 7 {sets(fusion)} {coarse}")
    extract = "extract.decider=tetra5 extract.placement=mid_edge extract.normals=false extract.min_weight=0.5"
    r.run("extract", f"run desk -o extract --to 7 {sets(extract)} {coarse}")
    r.path("mine.yaml").write_text("fusion: {voxel_size: 3 cm}\nacquire: {max_depth: 3 m, depth_scale: 10100}\n")
    r.run("config", f"run desk -o config --to 7 --config mine.yaml --quiet {BARE}")
    for number, damage in ((2, b""), (5, None)):  # an empty picture, and one that is not there
        picture = r.path(f"desk/depth/{number:06}.png")
        picture.unlink() if damage is None else picture.write_bytes(damage)
    r.run("damaged", f"run desk -o damaged --to 9 {coarse}")
    r.run("damaged_tracked", f"run desk -o damaged_tracked --to 9 --poses track {coarse}")


def sets(pairs):
    return " ".join(f"--set {pair}" for pair in pairs.split())


def finish(r):
    """Every step of finishing, alone and together, and textures."""
    scan(r, "desk", "desk --frames 24 --noise")
    coarse = "--preset object --set fusion.voxel_size=1cm --quiet"
    cases = {
        "small": "finish.watertight=small finish.max_hole=6cm",
        "full": "finish.watertight=full finish.mark_invented=magenta",
        "remove": "finish.ground=remove finish.ground_clearance=5mm",
        "cap": "finish.ground=cap finish.watertight=full finish.mark_invented=grey",
        "crop": "finish.crop.min_x=-0.3 finish.crop.max_x=0.2 finish.crop.max_z=0.1",
        "pieces": "extract.min_component_triangles=0 finish.min_piece_share=0.1 finish.min_piece_size=3cm",
        "smooth": "finish.smooth=5 finish.max_hole=3cm",
        "triangles": "finish.triangles=2000",
        "simplify": "finish.simplify_error=1mm",
        "place": "finish.up=ground finish.origin=ground",
        "all": "finish.ground=cap finish.watertight=full finish.min_piece_share=0.1 finish.smooth=2 "
               "finish.triangles=3000 finish.up=ground finish.origin=ground",
        "refused": "finish.ground=remove finish.ground_clearance=1m",
    }
    for name, keys in cases.items():
        r.run(name, f"run desk -o {name} {coarse} {sets(keys)} {BARE if name != 'all' else ''}")
    r.page("all")
    texture = "--set export.texture_size=512"
    r.run("png", f"run desk -o png {coarse} --texture {texture}")
    r.page("png")
    r.run("jpeg", f"run desk -o jpeg {coarse} {texture} {sets('export.texture=jpeg export.texel_size=4mm')}"
                  " --set export.preview=false")
    r.run("jpeg_of_all", f"run desk -o jpeg_of_all.glb {coarse} {texture} "
                         f"{sets('export.texture=jpeg ' + cases['all'])}")


def formats(r):
    """Every mesh file with its options."""
    scan(r, "sphere", "sphere --frames 12")
    coarse = "--set fusion.voxel_size=8mm --quiet"
    r.run("all", f"run sphere -o all {coarse} --set export.formats=[glb,ply,obj,stl,3mf]")
    for name in ("one.glb", "one.ply", "one.obj", "one.stl", "one.3mf"):
        r.run(f"alone_{name[4:]}", f"run sphere -o {name} {coarse}")
    r.run("unlit", f"run sphere -o unlit.glb {coarse} --set export.material=unlit")
    r.run("quantize", f"run sphere -o quantize.glb {coarse} --quantize")
    r.run("compress", f"run sphere -o compress.glb {coarse} --compress")
    r.run("both", f"run sphere -o both.glb {coarse} --quantize --compress")
    r.run("up", f"run sphere -o up {coarse} --set export.formats=[glb,ply,obj,stl,3mf] "
                "--set export.world_up=z --set export.up=y")
    r.run("bare", f"run sphere -o bare {coarse} --set export.formats=[obj] --set export.preview=false "
                  "--set extract.normals=false")


def loops(r):
    """A walk that closes a loop; tracking is lost and recovers on the way."""
    scan(r, "gallery", "gallery --frames 200 --noise --seed 4 --jpeg")
    track = "--poses track --preset room --set fusion.voxel_size=4cm --quiet"
    r.run("closed", f"run gallery -o closed {track}")
    r.page("closed")
    r.run("open", f"run gallery -o open {track} {BARE} --set fusion.loop_closure=false")
    r.run("textured", f"run gallery -o textured.glb {track} --to 120 --texture --set export.texture_size=512")


def turntable(r):
    """Turntables with unknown angles, an angle file or a step, and a walk that is no turntable."""
    scan(r, "tower", "tower --frames 24 --turntable --hand --angle-noise 0.5 --noise")
    scan(r, "desk", "desk --frames 60")
    table = "--preset turntable --set fusion.voxel_size=4mm --quiet"
    r.run("found", f"run tower -o found {table} --cut-recording cut --save-volume found.vdb")
    r.page("found")
    table += BARE
    keys = "fusion.voxel_size=4mm extract.min_component_triangles=0"
    r.run("of_cut", f"run cut -o of_cut {sets(keys)} --quiet {BARE}")
    r.run("angles", f"run tower -o angles {table} --angles tower/angles.txt")
    r.run("step", f"run tower -o step {table} --set turntable.step=15")
    r.run("wrong_step", f"run tower -o wrong_step {table} --set turntable.step=13")
    r.run("no_times", f"run tower -o no_times {table} --set turntable.rpm=2", said="error")
    r.run("whole", f"run tower -o whole {table} {sets('turntable.cut=false turntable.close_base=false')}")
    r.run("disabled", f"run tower -o disabled {table} --set turntable.enabled=false --poses track")
    r.run("print", f"run tower -o print --preset turntable --preset print {sets('fusion.voxel_size=4mm')} --quiet")
    r.run("texture", f"run tower -o texture.glb {table} --texture --set export.texture_size=512")
    r.run("still", f"run tower -o still {table} --poses still")
    r.run("half", f"run tower -o half {table} --every 2")
    none = "--preset turntable --poses track --set acquire.max_depth=0 --set fusion.voxel_size=2cm --quiet"
    r.run("none", f"run desk -o none --to 24 {none}")
    r.page("none")


def volumes(r):
    """Volumes in all formats."""
    samples = inputs.ball()
    inputs.write_nrrd(r.path("ball.nrrd"), samples, inputs.BALL, inputs.SPACING)
    inputs.write_nrrd(r.path("gzip.nrrd"), samples, inputs.BALL, inputs.SPACING, encoding="gzip")
    inputs.write_meta_image(r.path("ball.mha"), samples, inputs.BALL, inputs.SPACING)
    inputs.write_nifti(r.path("ball.nii"), samples, inputs.BALL, inputs.SPACING)
    inputs.write_dicom_series(r.path("dicom"), samples, inputs.BALL, inputs.SPACING)
    inputs.write_png_stack(r.path("stack"), samples, inputs.BALL)
    r.path("ball.raw").write_bytes(samples)
    r.path("big.raw").write_bytes(b"head" + inputs.swapped(samples))
    raw = "--dims 40x36x32 --type uint16 --spacing 0.5x0.5x0.75"
    known = {"nrrd": "ball.nrrd", "nrrd_gzip": "gzip.nrrd", "meta": "ball.mha", "nifti": "ball.nii",
             "dicom": "dicom", "stack": "stack --spacing 0.5x0.5x0.75", "raw": f"ball.raw {raw}",
             "big_endian": f"big.raw {raw} --byte-order big --header-bytes 4"}
    for name, volume in known.items():
        r.run(name, f"extract {volume} -o of_{name} --isovalue 600 --quiet {'' if name == 'nrrd' else BARE}")
        r.run(f"{name}_info", f"info {volume} --json", said="json")
    r.page("nrrd", "of_nrrd")
    r.run("no_surface", "extract ball.nrrd -o no_surface --isovalue 5000 --quiet", said="error")
    r.run("auto", "extract ball.nrrd -o auto --auto-isovalue --stats --json --quiet", said="json")
    r.run("low", "extract ball.nrrd -o low.ply --isovalue 600 --inside low --set extract.placement=mid_edge --quiet")
    r.run("finished", "extract ball.nrrd -o finished --isovalue 600 --quiet "
          + sets("export.formats=[glb,ply,obj,stl,3mf] finish.smooth=3 finish.triangles=1000"))
    streamed(r)
    deciders(r)
    of_a_scan(r)


def streamed(r):
    """A volume that is read a few slices at a time."""
    dims, spacing = (64, 64, 64), (0.25, 0.25, 0.5)
    samples = inputs.ball(dims, spacing)
    inputs.write_nrrd(r.path("long.nrrd"), samples, dims, spacing)
    r.path("long.raw").write_bytes(samples)
    limit = "--isovalue 600 --set extract.memory_budget=1MiB --json --quiet"
    r.run("streamed_ply", f"extract long.nrrd -o streamed.ply {limit}", said="json")
    r.run("streamed_stl", "extract long.raw --dims 64x64x64 --type uint16 --spacing 0.25x0.25x0.5 -o streamed.stl "
                          f"{limit}", said="json")
    r.run("streamed_folder", f"extract long.nrrd -o folder --set export.formats=[ply] {limit}", said="json")
    r.page("streamed_folder", "folder")
    r.run("not_streamed", "extract long.nrrd -o whole.ply --isovalue 600 --quiet")
    r.run("too_large", f"extract long.nrrd -o too_large.glb {limit}", said="error")


def deciders(r):
    """Every decider on random samples, which have all cases."""
    side = 20
    inputs.write_nrrd(r.path("noise.nrrd"), inputs.noise(side), (side, side, side), (1, 1, 1), kind="uint8")
    for decider in ("trilinear", "asymptotic", "chord", "knit", "fixed_high", "fixed_low", "tetra5", "tetra6",
                    "tetra24", "lorensen"):
        r.run(decider, f"extract noise.nrrd -o {decider}.ply --isovalue 127.5 --decider {decider} --json --quiet",
              said="json")


def of_a_scan(r):
    """The volume that a run saved."""
    scan(r, "desk", "desk --frames 24")
    saved = r.call("run desk -o desk.ply --set fusion.voxel_size=3cm --save-volume desk.vdb --quiet".split())
    if saved.returncode:
        raise RuntimeError(saved.stderr.decode())
    r.run("vdb", "extract desk.vdb -o vdb --quiet --set extract.min_weight=0.5")
    r.page("vdb")
    r.run("vdb_info", "info desk.vdb --json", said="json")
    r.run("vdb_inner", "extract desk.vdb -o inner.glb --isovalue 0.02 --decider asymptotic --quiet")
    r.run("vdb_finish", "extract desk.vdb -o closed --quiet"
          f"{BARE} {sets('finish.watertight=small finish.min_piece_size=10cm')}")


def align(r):
    """Range scans with and without poses and markers, one that does not fit, a mesh, and parts of a recording."""
    T_b = (50, (0.3, -0.1, 0.05))  # degrees about z, metres
    inputs.write_range_grid(r.path("a.ply"), inputs.hill_points(0))
    inputs.write_range_grid(r.path("b.ply.gz"), inputs.hill_points(50, *T_b))
    inputs.write_range_grid(r.path("far.ply"), inputs.hill_points(600, 20))
    r.run("found", "align a.ply b.ply.gz -o found --points found.pcd --save-volume found.vdb --quiet")
    r.page("found")
    r.run("far", "align a.ply far.ply -o far --quiet", said="error")
    r.page("far")
    r.path("two.conf").write_text("camera 0 0 0 0 0 0 1\nbmesh a.ply 0 0 0 0 0 0 1\nbmesh gone.ply 0 0 0 0 0 0 1\n"
                                  "bmesh b.ply.gz -0.1162331 0.2940922 -0.05 0 0 0.422618 0.906308\n")
    r.run("given", f"align two.conf -o given --quiet --set fusion.voxel_size=2mm --points given.ply {BARE}")
    r.run("refined", "align two.conf -o refined.ply --refine --quiet --json", said="json")
    r.run("initial", "align a.ply b.ply.gz -o initial.stl --initial found/trajectory.txt --json --quiet", said="json")
    r.path("markers.txt").write_text("1 cross 0.06 0.01 0\n1 dot 0.11 0.1 0\n1 ring 0.07 0.08 0.01\n" + "".join(
        f"b.ply.gz {name} {x} {y} {z}\n" for name, x, y, z in (
            ("cross", 0.3309, -0.0476, 0.05), ("dot", 0.2941, 0.0485, 0.05), ("ring", 0.2837, 0.005, 0.06))))
    r.run("markers", "align a.ply b.ply.gz -o markers.ply --markers markers.txt --json --quiet", said="json")
    r.run("meshed", "align b.ply.gz -o meshed.ply --quiet")
    r.run("with_mesh", f"align a.ply meshed.ply -o with_mesh --points with_mesh.ply --quiet{BARE}")
    scan(r, "turntable", "turntable --frames 60 --noise")
    inputs.write_part(r.path("turntable"), r.path("part1"), range(0, 9))
    inputs.write_part(r.path("turntable"), r.path("part2"), range(5, 14), flip=True)
    r.run("recordings", "align part1 part2 -o recordings --preset object --set fusion.voxel_size=5mm --quiet")
    r.page("recordings")


def convert(r):
    """Recordings in all layouts: written, read again, torn and repaired."""
    scan(r, "desk", "desk --frames 24 --jpeg")
    coarse = f"--set fusion.voxel_size=3cm {BARE} --quiet"
    camera = "--set acquire.intrinsics=[131.25,131.25,79.5,59.5]"
    scan(r, "full", "room --frames 2", size=FULL)
    for layout in ("mcap", "tum", "open3d", "7-scenes", "nerfstudio", "fakenect"):
        place, stated = ("desk.mcap", "") if layout == "mcap" else (f"as_{layout}", camera)
        # A dump of a Kinect has its size, and no poses.
        scanned, still = ("full", "--poses still") if layout == "fakenect" else ("desk", "")
        r.run(layout, f"convert {scanned} -o {place} --to {layout} --json --quiet", said="json")
        r.run(f"{layout}_info", f"info {place} --json {stated}", said="json")
        r.run(f"{layout}_run", f"run {place} -o of_{layout} {still} {stated} {coarse}")
    r.run("colmap", "convert desk -o as_colmap --to colmap --json --quiet", said="json")
    r.run("ros2", "convert desk -o as_ros2.mcap --to ros2 --json --quiet", said="json")
    write_ros2_bag(r.path("desk"), r.path("desk_ros2.mcap"))
    units = "--set acquire.depth_scale=" + str(json.loads(r.path("desk/camera_intrinsic.json").read_text())["depth_scale"])
    r.run("ros2_info", "info desk_ros2.mcap --json", said="json")
    r.run("ros2_run", f"run desk_ros2.mcap -o of_ros2 {units} {coarse}")
    r.run("ros2_convert", f"convert desk_ros2.mcap -o of_ros2.mcap --to mcap {units} --quiet")
    r.run("too_small", "convert desk -o too_small --to fakenect", said="error")
    r.run("back", "convert desk.mcap -o back --to open3d --quiet")
    r.run("twice", "convert desk -o desk.mcap --to mcap", said="error")
    inputs.write_pcd(r.path("wall.pcd"))
    r.run("pcd", f"run wall.pcd -o pcd --poses still {coarse}")
    r.run("pcd_info", "info wall.pcd --json", said="json")
    whole = r.path("desk.mcap").read_bytes()
    r.path("torn.mcap").write_bytes(whole[:len(whole) * 2 // 3])
    r.run("torn", f"run torn.mcap -o torn {coarse}")
    r.run("torn_info", "info torn.mcap --json", said="json")
    r.run("mended", "repair torn.mcap -o mended.mcap --json --quiet", said="json")
    r.run("mended_info", "info mended.mcap", said="text")
    r.run("in_place", "repair torn.mcap --json --quiet", said="json")
    r.keep_output("in_place", r.path("torn.mcap"))
    r.run("no_repair", "repair desk/camera_intrinsic.json", said="error")
    shutil.rmtree(r.path("desk/color"))
    r.run("grey", f"run desk -o grey {coarse}")


def commands(r):
    """Help, manual pages, completion, configuration, udev rules."""
    helped = r.run("help", "--help", said="text")
    listed = re.search(r"Subcommands:\n(.*?)\n\n", helped, re.DOTALL)[1]
    names = re.findall(r"^  ([a-z-]+)", listed, re.MULTILINE)
    for name in [*names, "config print", "config check", "config schema", "config docs"]:
        case = "help_" + name.replace(" ", "_")
        told = r.run(case, f"{name} --help", said="text")
        options = [re.split(r"\s{2,}", line.strip())[0] for line in told.splitlines() if re.match(r"\s+-", line)]
        r.keep("bytes", f"{case}/options", sha256("\n".join(options)))
    for shell in ("bash", "zsh", "fish"):
        r.run(f"completion_{shell}", f"completion {shell}", said="text")
    r.call(["man", "-o", "man"])
    pages = sorted(r.path("man").iterdir())
    r.keep("bytes", "man/names", sha256("\n".join(page.name for page in pages)))
    for page in pages:
        r.keep("texts", f"man/{page.name}", sha256(page.read_bytes()))
    for case, command in (("config", "config print"), ("config_defaults", "config print --defaults")):
        r.keep("bytes", f"{case}/keys", sha256(keys_of(r.run(case, command, said="text"))))
    r.run("config_schema", "config schema", said="json")
    r.run("config_docs", "config docs", said="text")
    rules = r.run("udev_rules", "udev-rules", said="text")
    r.keep("bytes", "udev_rules/rules", sha256("\n".join(re.findall(r"^[^#\n].*", rules, re.MULTILINE))))
    r.run("udev_rule", "udev-rules --device 1234:5678", said="text")
    r.path("good.yaml").write_text("fusion: {voxel_size: 3 mm}\n")
    r.path("bad.yaml").write_text("fusion: {voxel_size: 0}\nextract: {desider: chord, isovalue: high}\nlens: 3\n")
    r.run("config_good", "config check good.yaml", said="text")
    r.run("config_bad", "config check bad.yaml", said="error")


def errors(r):
    """Every exit code except 1 and 130. An error leaves existing files as they were."""
    scan(r, "sphere", "sphere --frames 12")
    coarse = "--set fusion.voxel_size=8mm --quiet"
    for name in ("model.ply", "none.glb"):
        r.path(name).write_text("mine\n")
    r.path("empty").mkdir()
    cases = {
        "no_command": "", "no_such_command": "rum", "no_such_option": "run sphere -o out2 --vozel 3",
        "no_output": "run sphere", "bad_ending": f"run sphere -o out2.xyz {coarse}",
        "no_such_scene": "synth spere -o out2", "no_such_layout": "convert sphere -o out2 --to betamax",
        "bad_value": "run sphere -o out3 --set fusion.voxel_size=0",
        "no_such_key": "run sphere -o out3 --set fusion.voxl=1", "no_such_preset": "run sphere -o out3 --preset objekt",
        "no_such_config": "run sphere -o out3 --config none.yaml",
        "no_recording": f"run nowhere -o out4 {coarse}", "no_frames": f"run empty -o out4 {coarse}",
        "no_frames_left": f"run sphere -o out4b --from 50 {coarse}", "no_volume": "extract nowhere.nrrd -o out4",
        "bad_mesh": "info model.ply",
        "empty_mesh": f"run sphere -o out7 {coarse} --set extract.min_component_triangles=1000000",
        "over_a_file": f"run sphere -o model.ply/out {coarse}", "budget": f"run sphere -o out9 {coarse} "
        "--set fusion.bricks=off --set fusion.memory_budget=8 --set fusion.voxel_size=0.3mm",
        "bad_volume": "extract none.glb -o out4 --isovalue 3",
    }
    for name, command in cases.items():
        r.run(name, command, said="error")
    r.run("no_camera", "capture --device usb:0000:0000 -o out5 --quiet")  # its message depends on the computer
    r.keep_output("untouched", r.path("model.ply"))


def measures(r):
    """`distance`, `info` and `report`."""
    scan(r, "turntable", "turntable --frames 24")
    r.run("mesh", "run turntable -o mesh --preset object --set fusion.voxel_size=5mm --quiet "
          + sets("export.formats=[glb,ply,obj,stl,3mf]"))
    r.run("distance", "distance mesh/model.ply turntable --json", said="bytes")
    r.run("distance_text", "distance mesh/model.ply turntable", said="text")
    r.run("distance_moved", "distance mesh/model.stl turntable --trajectory mesh/trajectory.txt --json", said="bytes")
    for kind in ("glb", "ply", "obj", "stl"):
        r.run(f"info_{kind}", f"info mesh/model.{kind} --json", said="json")
    r.run("info_text", "info mesh/model.ply", said="text")
    r.run("info_recording", "info turntable", said="text")
    r.run("info_recording_json", "info turntable --json", said="json")
    r.run("report", "report mesh --json --quiet", said="bytes")


def recordings(r):
    """A few frames of each real recording."""
    wide, fine = "--set fusion.voxel_size=4cm --quiet", "--set fusion.voxel_size=1cm --quiet"
    near = "--set acquire.max_depth=1.5"
    cases = {  # folder, what its camera and its poses are, what else
        "box": ("rgbd_box_f200", "", f"--to 11 {fine}"),
        "box_tracked": ("rgbd_box_f200", "", f"--to 11 --poses track {fine} {BARE}"),
        "icl": ("rgbd_icl_3/dataset", "--preset icl_nuim", wide),
        "sun3d": ("rgbd_sun3d_studyroom_5/3dmatch", "--preset room", wide),
        "redwood": ("rgbd_redwood_lr1_211", "", f"--to 11 {wide}"),
        "redwood_refined": ("rgbd_redwood_lr1_211", "", f"--to 11 --poses refine {wide} {BARE}"),
        "tum": ("rgbd_tum_fr1_rpy_150", "--preset tum_freiburg1", f"--to 39 {wide} {BARE}"),
        "tum_tracked": ("rgbd_tum_fr1_rpy_150", "--preset tum_freiburg1", f"--to 39 --poses track {wide}"),
        "pclzf": ("pclzf", "--preset kinect_v1", f"--poses still {wide}"),
        "bag": ("realsense_bag", "--preset realsense_d400", f"--poses still {wide}"),
        "phone": ("rgbd_iphone_lidar_corridor_73", "--preset phone_lidar", f"--to 19 {wide} {BARE}"),
        "table": ("rgbd_d435i_table_48", "--preset realsense_d400", f"--to 5 {near} {fine} {BARE}"),
        "shelf": ("rgbd_shelf_masks_15", "--set acquire.intrinsics=[611.355,611.4,337.406,247.19] "
                  "--set acquire.depth_scale=10000", f"{near} {fine} {BARE}"),
    }
    data = data_folder()
    for place in [*(place for place, _, _ in cases.values()), "range_stanford_bunny", "meshes"]:
        if not (data / place).is_dir():
            raise Missing(f"no recording at {data / place}")
    r.path("data").symlink_to(data.resolve())
    for name, (place, camera, options) in cases.items():
        r.run(name, f"run data/{place} -o {name} {camera} {options}")
        r.run(f"{name}_info", f"info data/{place} --json {camera}", said="json")
    r.run("bag_converted", "convert data/realsense_bag -o bag.mcap --to mcap --quiet")
    r.run("bunny", "align data/range_stanford_bunny/bun.conf -o bunny --set fusion.voxel_size=2mm --quiet")
    r.page("bunny")
    r.run("spot", f"synth data/meshes/spot.obj -o spot --size 20cm --frames 4 {SMALL}")


SUITES = (synth, presets, run, finish, formats, loops, turntable, volumes, align, convert, commands, errors, measures,
          recordings)
