"""The renderer against Blender's Cycles: the same glTF, camera, lens and light; pictures matched, then timed.

    blender --background --python-exit-code 1 --python tools/compare_cycles.py -- PROGRAM build/release/scenes/portrait.json OUT WIDTH

PROGRAM is build/release/tools/dualpixel; OUT, a new folder, gets cycles.json; WIDTH in photosites divides the scene's (192:
four minutes on two cores, 384: eleven). Needs Debian's blender (3.4) and python3-numpy; nothing else does.

What is matched: a thin lens (lens_models/phone_thin_4.4mm_f1.8.json) in place of the scene's own, its pupil and focus; one environment picture, read by both; the sun without a width; direct
light alone; a photosite's own area as the pixel's filter. All materials are made matte (roughness 1, no metal) in a copy
of the scene, as the two programs' glossy surfaces follow different models. Ours is the capture's `photograph` at an
aperture scale of 1: the undivided picture.

Time is CPU time of all threads, and marginal: that of N samples minus that of the fewest, so that reading the scene and
starting up count for neither. Ours includes points of light on surfaces, of as many light samples as the picture has
samples: the fewest samples that are subtracted are rendered without points. Error is the RMS over the picture and R, G,
B: the standard deviation between pictures of three seeds and, in quadrature, what points of light leave wrong in ours,
which is found beside as many pictures with all light sampled by every path. On average no reference's noise is in it.
Light at points is the same for all seeds, so that the standard error does not know its scatter.
"""

import json
import math
import os
import resource
import struct
import subprocess
import sys
import time

import bpy
import numpy as np

SAMPLES = (64, 128, 256, 512)
SEEDS = (3, 4, 5)
THIN_LENS = "phone_thin_4.4mm_f1.8.json"  # a prescription's distortion and vignetting are not Cycles's
NITS = 1e-4  # Cycles' unit of radiance: keeps its numbers near 1


def matte_copy(source, target):
    """Writes `source` (GLB) with every material matte; returns its JSON."""
    with open(source, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    gltf = json.loads(data[20 : 20 + length])
    for material in gltf["materials"]:
        material["pbrMetallicRoughness"].update(metallicFactor=0, roughnessFactor=1)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    with open(target, "wb") as file:
        file.write(b"glTF" + struct.pack("<II", 2, 20 + len(text) + len(rest)))
        file.write(struct.pack("<I", len(text)) + b"JSON" + text + rest)
    return gltf


def write_environment(path):
    """A smooth sky in nits, equirectangular, row 0 straight up."""
    v, u = np.mgrid[0:128, 0:256]
    height = np.cos(np.pi * (v + 0.5) / 128)
    across = np.sin(np.pi * (v + 0.5) / 128) * np.sin(2 * np.pi * ((u + 0.5) / 256 - 0.5))
    nits = np.where(height > 0, 4000 + 3500 * (1 - np.abs(height)) ** 4, 2200) + 12000 * np.exp(6 * (across - 1))
    rgba = np.ones((128, 256, 4), np.float32)
    rgba[..., :3] = nits[..., None] * np.array([0.9, 1.0, 1.15])
    image = bpy.data.images.new("sky", 256, 128, float_buffer=True, is_data=True)
    image.pixels.foreach_set(rgba[::-1].ravel())  # Blender's rows go upwards
    image.filepath_raw, image.file_format = path, "OPEN_EXR"
    image.save()
    return image


def read_exr(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(image.size[1], image.size[0], -1)[::-1, :, :3].astype(np.float64)
    bpy.data.images.remove(image)
    return pixels


def our_scene(source, out, width):
    """The scene file that both render, as JSON: of `source`, with the copy of its glTF and the common sky."""
    with open(source) as file:
        scene = json.load(file)
    folder = os.path.dirname(os.path.abspath(source))
    lenses = os.path.dirname(os.path.join(folder, scene["lens"]["file"]))
    scene["lens"] = {"file": os.path.join(lenses, THIN_LENS)}
    scene["environment"] = {"model": "file", "path": "sky.exr"}
    scene["gltf"] = "matte.glb"
    scene["burst"] = {"frames": 1}
    sensor = scene["sensor"]
    scale = sensor["width_px"] // width
    sensor.update(width_px=width, height_px=sensor["height_px"] // scale)
    sensor["pixel_pitch_um"] *= scale
    scene.pop("face_px", None)
    scene["truth"] = {"photograph_aperture_scale": 1}
    scene["render"] = {"samples_per_pixel": 1, "all_in_focus_samples_per_pixel": 1, "max_bounces": 0}
    with open(os.path.join(out, "matte.json"), "w") as file:
        json.dump(scene, file)
    return scene


def render_ours(program, out, samples, seed, points=True):
    """The picture in nits, and CPU seconds of the whole program."""
    capture = os.path.join(out, "capture")
    command = [program, "simulate", os.path.join(out, "matte.json"), "-o", capture, "--seed", str(seed)]
    command += ["--set", f"render.photograph_samples_per_pixel={samples}"]
    light = f"light_samples={samples}" if points else "light_spacing_px=0"
    command += ["--set", f"render.{light}"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return read_exr(os.path.join(capture, "truth", "photograph.exr")), cpu_s


def matte_shaders():
    for material in bpy.data.materials:
        if not material.use_nodes:
            continue
        tree = material.node_tree
        principled = [n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"]
        output = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"]
        if not principled or not output:
            continue
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        color = principled[0].inputs["Base Color"]
        if color.is_linked:
            tree.links.new(color.links[0].from_socket, diffuse.inputs["Color"])
        else:
            diffuse.inputs["Color"].default_value = color.default_value
        tree.links.new(diffuse.outputs["BSDF"], output[0].inputs["Surface"])


def set_up_lights(gltf, sky):
    sun = gltf["extensions"]["KHR_lights_punctual"]["lights"][0]
    for light in [o.data for o in bpy.data.objects if o.type == "LIGHT"]:
        light.energy, light.color, light.angle = sun["intensity"] * NITS, sun["color"], 0
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    picture = nodes.new("ShaderNodeTexEnvironment")
    picture.image = sky
    mapping, coordinates = nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeTexCoord")
    mapping.inputs["Rotation"].default_value[2] = -math.pi / 2  # our middle column is glTF's -z, Blender's +y
    links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    background = nodes["Background"]
    links.new(picture.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = NITS


def set_up_camera(description, focus_m):
    camera = bpy.context.scene.camera.data
    focal_mm, f_number = description["focal_length_mm"], description["f_number"]
    image_mm = focal_mm / (1 - focal_mm / (1e3 * focus_m))
    camera.lens, camera.sensor_fit = focal_mm, "HORIZONTAL"
    camera.sensor_width = description["width_px"] * 1e-3 * description["pixel_pitch_um"] * focal_mm / image_mm
    camera.clip_start, camera.clip_end = 1e-3, 1e5
    camera.dof.use_dof = True
    camera.dof.focus_distance, camera.dof.aperture_fstop = focus_m, f_number


def set_up_cycles(glb, gltf, sky, description, focus_m):
    if not hasattr(np, "bool"):
        np.bool = bool  # Debian's glTF importer asks for it by its old name
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    bpy.ops.import_scene.gltf(filepath=glb)
    scene = bpy.context.scene
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    matte_shaders()
    set_up_lights(gltf, sky)
    set_up_camera(description, focus_m)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = description["width_px"], description["height_px"]
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles = scene.cycles
    cycles.device, cycles.max_bounces = "CPU", 0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = 0
    cycles.pixel_filter_type = "BOX"


def render_cycles(out, samples, seed):
    """The picture in nits, and CPU seconds of the render."""
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = os.path.join(out, "cycles.exr")
    start = time.process_time()
    bpy.ops.render.render(write_still=True)
    return read_exr(scene.render.filepath) / NITS, time.process_time() - start


def time_at(rows, error):
    """Straight between rows on log axes; None outside of them."""
    for a, b in zip(rows, rows[1:]):
        if b["rmse_nits"] <= error <= a["rmse_nits"]:
            share = math.log(a["rmse_nits"] / error) / math.log(a["rmse_nits"] / b["rmse_nits"])
            return a["cpu_s"] * (b["cpu_s"] / a["cpu_s"]) ** share
    return None


def standard_error(values):
    return float(np.std(values, ddof=1) / math.sqrt(len(values)))


def variance(pictures):
    """Of one picture, mean over pixels."""
    return float(np.mean(np.var(pictures, axis=0, ddof=1)))


def squared_difference_of_means(a, b):
    """Of two lists of pictures, mean over pixels, the pictures' noise taken off; not below 0, where noise may take it."""
    noise = variance(a) / len(a) + variance(b) / len(b)
    return max(float(np.mean((np.mean(a, axis=0) - np.mean(b, axis=0)) ** 2)) - noise, 0)


def jackknife(estimate, values):
    """Standard error of estimate(values), from leaving out each (Tukey 1958)."""
    without = [estimate(values[:i] + values[i + 1 :]) for i in range(len(values))]
    return math.sqrt((len(values) - 1) * float(np.var(without)))


def measure(render, fewest, without_points=None):
    """Rows, and the pictures of the last one. `fewest`: of CPU seconds, what counts for nothing. `without_points`:
    pictures with all light sampled by every path, where `render` has points of light."""
    rows = []
    for samples in SAMPLES:
        runs = [render(samples, seed) for seed in SEEDS]
        pictures = [picture for picture, _ in runs]
        times = [max(cpu_s - fewest, 1e-3) for _, cpu_s in runs]
        of_points = lambda some: squared_difference_of_means(some, without_points) if without_points else 0
        rmse = lambda some: math.sqrt(variance(some) + of_points(some))
        rows.append({
            "samples": samples,
            "cpu_s": float(np.mean(times)),
            "cpu_s_standard_error": standard_error(times),
            "rmse_nits": rmse(pictures),
            "rmse_standard_error": jackknife(rmse, pictures),
        })
        if without_points:
            rows[-1]["points_error_nits"] = math.sqrt(of_points(pictures))
    return rows, pictures


def main():
    program, source, out, width = sys.argv[sys.argv.index("--") + 1 :]
    out = os.path.abspath(out)
    os.makedirs(out)
    scene = our_scene(source, out, int(width))
    gltf_path = os.path.join(os.path.dirname(os.path.abspath(source)), json.load(open(source))["gltf"])
    gltf = matte_copy(gltf_path, os.path.join(out, "matte.glb"))
    sky = write_environment(os.path.join(out, "sky.exr"))

    ours = lambda samples, seed: render_ours(program, out, samples, seed)
    plain = lambda samples, seed: render_ours(program, out, samples, seed, points=False)
    without_points = [plain(SAMPLES[-1], seed + len(SEEDS))[0] for seed in SEEDS]
    with open(os.path.join(out, "capture", "capture.json")) as file:
        capture = json.load(file)
    description = capture["camera"]
    set_up_cycles(os.path.join(out, "matte.glb"), gltf, sky, description, scene["camera"]["focus_distance_m"])
    cycles = lambda samples, seed: render_cycles(out, samples, seed)
    fewest = lambda render: min(render(1, 7)[1] for _ in range(2))

    # our pictures are in the frames' signal: one factor for all of a capture, found from the exposure
    focus_m, focal_m = description["focus_distance_m"], 1e-3 * description["focal_length_mm"]
    rim = 0.5 * focal_m / description["f_number"] * (1 - focal_m / focus_m) / focal_m
    nits_per_unit = capture["exposure"]["lux_s_per_unit"] / (math.pi * rim**2 * scene["exposure"]["time_s"])
    without_points = [picture * nits_per_unit for picture in without_points]
    our_rows, _ = measure(
        lambda n, seed: (lambda p: (p[0] * nits_per_unit, p[1]))(ours(n, seed)), fewest(plain), without_points
    )
    rows, theirs = measure(cycles, fewest(cycles))
    mean, our_mean = float(np.mean(theirs)), float(np.mean(without_points))
    result = {
        "scene": os.path.basename(source),
        "width_px": int(width),
        "seeds": len(SEEDS),
        "mean_nits": {"ours": our_mean, "cycles": mean},
        "difference_of_means": our_mean / mean - 1,
        "rms_difference": math.sqrt(squared_difference_of_means(without_points, theirs)) / mean,
        "ours": our_rows,
        "cycles": rows,
    }
    result["time_of_cycles_over_ours"] = [
        {"rmse_nits": row["rmse_nits"], "ratio": row["cpu_s"] / time_at(result["ours"], row["rmse_nits"])}
        for row in result["cycles"]
        if time_at(result["ours"], row["rmse_nits"])
    ]
    with open(os.path.join(out, "cycles.json"), "w") as file:
        json.dump(result, file, indent=2)
    print(json.dumps(result, indent=2))


main()
