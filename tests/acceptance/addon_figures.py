r"""How long the add-on's pictures take, and how clean they are. In Blender, or in Python with bpy:

    blender -b -noaudio --factory-startup --python-exit-code 1 --python addon_figures.py -- \
        times LIGHT.exr MAPS OUT.csv [SAMPLES REFERENCE [X Y WIDTH HEIGHT]]
        edits LIGHT.exr OUT.csv MAPS...
        photos LIGHT.exr OUT.csv FOLDER MAPS...
    python3 addon_figures.py chart OUT.svg LABEL=TIMES.csv...            (gnuplot)

times: seconds of a processor (user + system), because
other programs may run, and PSNR of the sRGB values over the person against 256 samples of other random numbers: a line
for each number of samples, without and with the denoiser where there is one, and for Eevee. SAMPLES: those numbers with
commas; REFERENCE: samples to compare with, fewer for large maps. X Y WIDTH HEIGHT: only this part of the picture, in pixels
from its lower left corner, is rendered. A run that is stopped leaves the lines that it has.

edits: the two largest garments of each person (fabric or leather), each made red, and polished (roughness 0.1): mean
absolute change outside the garment, where other garments' and classes' pixels are, of the maps (linear albedo, roughness)
and of the picture's sRGB values, lit directly alone and with bounces. What bounces off a red garment is red: that is
light, not a leak. A pixel is outside where no share of the garment is in it.

photos: estimated maps of people in white shirts, relit by LIGHT and by a disc behind the person (20 degrees wide, radiance
50, 20 degrees up); pictures into FOLDER. The shirt is what has an albedo above code 153, 3 px from the outline. Needs NumPy.
"""
import array
import csv
import math
import os
import resource
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SAMPLES = (1, 2, 4, 8, 16, 32, 64, 128)
REFERENCE, REFERENCE_SEED = 256, 7


def processor_s():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def peak_gb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


class Studio:
    """A person under a light, at the maps' size."""

    def __init__(self, light, maps_folder):
        import bpy
        sys.path.insert(0, os.path.join(HERE, "..", "..", "blender_addon"))
        from human_material import compat
        from human_material.services import decode, environment, maps, relief, render
        self.bpy, self.compat, self.decode, self.maps, self.render = bpy, compat, decode, maps, render
        self.scene = bpy.context.scene
        for item in list(self.scene.objects):
            bpy.data.objects.remove(item)
        start = processor_s()
        self.item, self.loaded = relief.load_into(self.scene, maps_folder)
        self.import_s = processor_s() - start
        self.skin = relief.material_of(self.item)
        environment.set_environment(self.scene, light)
        environment.show_background(self.scene, False)
        self.folder = tempfile.mkdtemp(prefix="hm_figures")
        self.part = (0, 0, *self.loaded.size)

    def show_part(self, x, y, width, height):
        """From here on only this part is rendered."""
        whole_width, whole_height = self.loaded.size
        settings, self.part = self.scene.render, (x, y, width, height)
        settings.use_border = settings.use_crop_to_border = True
        settings.border_min_x, settings.border_max_x = x / whole_width, (x + width) / whole_width
        settings.border_min_y, settings.border_max_y = y / whole_height, (y + height) / whole_height

    def mask(self):
        """Of the part."""
        x, y, width, height = self.part
        return [self.loaded.mask[(y + v) * self.loaded.size[0] + x + u] for v in range(height) for u in range(width)]

    def picture(self, samples, seed=0, engine="CYCLES", denoise=False):
        """(linear values, seconds of a processor)."""
        self.render.prepare(self.scene, samples, seed)
        self.render.set_pixel_exact(self.scene, self.skin, True)
        self.scene.cycles.use_denoising = denoise
        if engine != "CYCLES":
            self.scene.render.engine = engine
            self.scene.eevee.taa_render_samples = samples
        path = os.path.join(self.folder, "picture.exr")
        start = processor_s()
        self.render.to_file(self.scene, path)
        seconds = processor_s() - start
        return self.maps.read_raster(path, 3, *self.part[2:]), seconds

    def srgb_of(self, values, pixels):
        """sRGB values of those pixels, one pixel after another: of large pictures only the person is looked at."""
        return array.array("f", (self.decode.linear_to_srgb(min(max(values[3 * p + c], 0.0), 1.0))
                                 for p in pixels for c in range(3)))


def mean_change(a, b, pixels, channels=3):
    return sum(abs(a[channels * p + c] - b[channels * p + c]) for p in pixels for c in range(channels)) / (
        channels * max(len(pixels), 1))


def psnr(a, b):
    return -10 * math.log10(max(sum((u - v) ** 2 for u, v in zip(a, b)) / len(a), 1e-12))


def times(light, folder, output, samples="", reference=REFERENCE, *part):
    counts = [int(count) for count in samples.split(",")] if samples else SAMPLES
    studio = Studio(light, folder)
    if part:
        studio.show_part(*map(int, part))
    covered = [p for p, m in enumerate(studio.mask()) if m > 0.5]
    with open(output, "w", newline="", encoding="utf-8") as file:
        def row(*cells):
            csv.writer(file).writerow(cells)
            file.flush()
            print(*cells, flush=True)

        def measure(engine, count, denoise=False):
            found, seconds = studio.picture(count, engine=engine, denoise=denoise)
            row("cycles" if engine == "CYCLES" else "eevee", "denoised" if denoise else "", count, round(seconds, 2),
                round(psnr(studio.srgb_of(found, covered), truth), 2))

        row("way", "denoiser", "samples", "processor_s", "psnr_db")
        row("import", "", 0, round(studio.import_s, 2), "")
        found, seconds = studio.picture(int(reference), REFERENCE_SEED)
        truth = studio.srgb_of(found, covered)
        print("reference %.2f s, %.2f GB at most" % (seconds, peak_gb()), flush=True)
        for denoise in [False] + [True] * studio.compat.can_denoise():
            for count in counts:
                measure("CYCLES", count, denoise)
        for engine in ("BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"):
            try:
                for count in (1, 16):
                    measure(engine, count)
            except (TypeError, RuntimeError, OSError) as error:   # none of that name, or no display
                print("%s: %s" % (engine, error), flush=True)


BOUNCES = (0, 12)
EDITS = (("red", dict(color=(0.5, 0.02, 0.02))), ("polished", dict(roughness=0.1)))
EDIT_SAMPLES = 8


def edits(light, output, *folders):
    rows = []
    for folder in folders:
        studio = Studio(light, folder)
        from human_material.services import garment_edit
        for number, name, _ in [g for g in garment_edit.all_of(studio.skin) if g[1] in ("fabric", "leather")][:2]:
            rows += edits_of(studio, folder, number, name)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


def edits_of(studio, folder, number, class_name):
    """A row for each edit of one garment."""
    from human_material.services import classes, edit, edited, garment_edit, presets
    key, _ = garment_edit.node_for(studio.skin, number)
    numbers, shares = garment_edit.numbers_of(studio.skin)[0], studio.loaded.shares
    own, every = classes.NAMES.index(class_name), len(classes.NAMES)
    person = [p for p, m in enumerate(studio.loaded.mask) if m > 0.5]
    parts = {True: [], False: []}
    for p in person:
        parts[numbers[p] == number and shares[every * p + own] > 0].append(p)
    before = look(studio, edited)
    for name, values in EDITS:
        edit.apply(studio.skin, key, presets.Preset(name, name, **values))
        after = look(studio, edited)
        edit.reset(studio.skin, key)
        row = {"maps": os.path.basename(os.path.dirname(os.path.abspath(folder))), "garment": number, "class": class_name,
               "pixels": len(parts[True]), "edit": name}
        for what in before:
            channels = 1 if what == "roughness" else 3
            for side, pixels in (("inside", parts[True]), ("outside", parts[False])):
                row[what + " " + side] = "%.2g" % mean_change(before[what], after[what], pixels, channels)
        print("edit", *row.values(), flush=True)
        yield row


def look(studio, edited):
    """The maps with their edits, and pictures of the same random numbers."""
    maps = edited.rasters(studio.skin)[0]
    found = {name: maps[name] for name in ("diffuse", "roughness")}
    for bounces in BOUNCES:
        studio.scene.cycles.max_bounces = bounces
        values = studio.picture(EDIT_SAMPLES)[0]
        found["%d bounces" % bounces] = studio.srgb_of(values, range(len(values) // 3))
    return found


SHIRT_CODE, OUTLINE_PX, WINDOW_PX, DARK = 153, 3, 11, 0.4
ROW = ("photo", "px", "shirt_px", "albedo", "relit", "speckle", "glow", "dark", "outline", "processor_s")
DISC = 50.0, 20.0, 20.0   # radiance, width and height above the horizon, degrees


def disc(path):
    """An environment with a disc on -Z, behind the person."""
    sys.path.insert(0, os.path.join(HERE, "..", "addon"))
    from support import image_files
    width, values = 512, []
    radiance, wide, high = DISC[0], math.radians(DISC[1] / 2), math.radians(DISC[2])
    for y in range(width // 2):
        up = math.pi * (0.5 - (y + 0.5) / (width // 2))
        for x in range(width):
            turn = 2 * math.pi * ((x + 0.5) / width - 0.25)   # from -Z
            cosine = math.sin(up) * math.sin(high) + math.cos(up) * math.cos(high) * math.cos(turn)
            values += [radiance * (cosine > math.cos(wide))] * 3
    image_files.exr(path, width, width // 2, values)


def within(np, inside, pixels):
    """The pixels of a mask that are so far from its end."""
    for _ in range(pixels):
        inside = inside.copy()
        inside[1:-1, 1:-1] &= inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:]
    return inside


def median_around(np, values, size):
    padded = np.pad(values, [(size // 2, size // 2)] * 2 + [(0, 0)], mode="edge")
    return np.concatenate([np.median(np.lib.stride_tricks.sliding_window_view(padded[y:y + size], (size, size), (0, 1)),
                                     axis=(-1, -2)) for y in range(len(values))])


def codes(np, values):
    values = np.clip(values, 0, 1)
    return 255 * np.where(values <= 0.0031308, 12.92 * values, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055)


def photos(light, output, folder, *maps):
    import numpy as np
    os.makedirs(folder, exist_ok=True)
    behind = os.path.join(folder, "disc.exr")
    disc(behind)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ROW)
        writer.writeheader()
        for path in maps:
            row = photo(np, path, light, behind, folder)
            writer.writerow(row)
            print(row, flush=True)


def photo(np, path, light, behind, folder):
    name = os.path.basename(os.path.abspath(path))
    pictures, seconds = {}, {}
    for key, environment in (("light", light), ("behind", behind)):
        studio = Studio(environment, path)
        width, height = studio.loaded.size
        values, seconds[key] = studio.picture(64)
        pictures[key] = np.array(values).reshape(height, width, 3)
        save_png(studio, os.path.join(folder, "%s_%s.png" % (name, key)), codes(np, pictures[key]) / 255)
    albedo = codes(np, np.array(studio.loaded.diffuse).reshape(height, width, 3))
    inside = np.array(studio.loaded.mask).reshape(height, width) > 0.5
    shirt = within(np, inside, OUTLINE_PX) & (albedo.min(2) > SHIRT_CODE)
    relit = codes(np, pictures["light"])
    speckle = (relit - median_around(np, relit, 5))[shirt]
    grey = pictures["light"].mean(2, keepdims=True)
    dark = within(np, inside, OUTLINE_PX) & (grey < DARK * median_around(np, grey, WINDOW_PX))[..., 0]
    lit = pictures["behind"].mean(2)
    rim = lit[inside & ~within(np, inside, 1)].mean() / lit[within(np, inside, 2) & ~within(np, inside, 4)].mean()

    def mean(values):
        return " ".join("%.3g" % v for v in values[shirt].mean(0))
    return {"photo": name, "px": width, "shirt_px": int(shirt.sum()), "albedo": mean(albedo), "relit": mean(relit),
            "speckle": "%.1f" % math.sqrt((speckle ** 2).mean()), "glow": mean(pictures["behind"]),
            "dark": int(dark.sum()), "outline": "%.2f" % rim, "processor_s": "%.1f" % seconds["light"]}


def save_png(studio, path, values):
    height, width, _ = values.shape
    image = studio.bpy.data.images.new("picture", width, height)
    flat = [1.0] * (4 * width * height)
    for c in range(3):
        flat[c::4] = values[..., c].ravel().tolist()
    image.pixels.foreach_set(flat)
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()


COLORS = ("#7b3294", "#d55e00", "#0072b2", "#009e73", "#000000", "#cc79a7")
#: (way, denoiser) -> words, line and point: a colour is a version and a size
WAYS = {("cycles", ""): ("Cycles", "dashtype 1 pointtype 7"), ("cycles", "denoised"): ("denoised", "dashtype 2 pointtype 5"),
        ("eevee", ""): ("Eevee", "dashtype 3 pointtype 9")}
CLEAN_DB = 30   # a preview in which noise is hardly seen


def chart(output, *labelled):
    lines, data = [], ""
    for entry, color in zip(labelled, COLORS):
        label, _, path = entry.partition("=")
        with open(path, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for (way, denoiser), (words, look_of_line) in WAYS.items():
            mine = [row for row in rows if (row["way"], row["denoiser"]) == (way, denoiser)]
            if mine:
                name = "line%d" % len(lines)
                data += "$%s << end\n%s\nend\n" % (name, "\n".join(
                    "%s %s %s" % (row["processor_s"], row["psnr_db"], row["samples"]) for row in mine))
                lines.append("$%s using 1:2 with linespoints pointsize 0.5 lc rgb '%s' %s title '%s, %s', '' using 1:2:3 "
                             "with labels offset 0,0.8 font ',8' notitle" % (name, color, look_of_line, label, words))
    script = ("set terminal svg size 900,440 font 'sans,11' background 'white'\nset output '%s'\nset logscale x\n"
              "set xlabel 'seconds of a processor'\nset ylabel 'PSNR, dB'\nset key outside right\nset grid\n%s\n"
              "plot %s, %d with lines lc rgb '#999999' title 'clean preview'\n"
              % (output, data, ", ".join(lines), CLEAN_DB))
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    {"times": times, "edits": edits, "photos": photos, "chart": chart}[arguments[0]](*arguments[1:])
    sys.stdout.flush()
    if "bpy" in sys.modules and not sys.modules["bpy"].app.binary_path:
        os._exit(0)   # some modules crash when Python ends
