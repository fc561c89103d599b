r"""How long the add-on's pictures take, and how clean they are. In Blender, or in Python with bpy:

    blender -b -noaudio --factory-startup --python-exit-code 1 --python addon_figures.py -- \
        times LIGHT.exr MAPS OUT.csv [LARGE_MAPS]
        edits LIGHT.exr OUT.csv MAPS...
    python3 addon_figures.py chart OUT.svg LABEL=TIMES.csv...            (gnuplot)

times: seconds of a processor (user + system), because
other programs may run, and PSNR of the sRGB values over the person against 256 samples of other random numbers: a line
for each number of samples, without and with the denoiser where there is one, and for Eevee; then for the large maps.

edits: the two largest garments of each person (fabric or leather), each made red, and polished (roughness 0.1): mean
absolute change outside the garment, where other garments' and classes' pixels are, of the maps (linear albedo, roughness)
and of the picture's sRGB values, lit directly alone and with bounces. What bounces off a red garment is red: that is
light, not a leak. A pixel is outside where no share of the garment is in it.
"""
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

    def picture(self, samples, seed=0, engine="CYCLES", denoise=False):
        """(sRGB values, seconds of a processor)."""
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
        values = self.maps.read_raster(path, 3, *self.loaded.size)
        return [self.decode.linear_to_srgb(min(max(v, 0.0), 1.0)) for v in values], seconds


def mean_change(a, b, pixels, channels=3):
    return sum(abs(a[channels * p + c] - b[channels * p + c]) for p in pixels for c in range(channels)) / (
        channels * max(len(pixels), 1))


def psnr(a, b, pixels):
    error = sum((a[3 * p + c] - b[3 * p + c]) ** 2 for p in pixels for c in range(3)) / (3 * len(pixels))
    return -10 * math.log10(max(error, 1e-12))


def times(light, folder, output, large=""):
    studio = Studio(light, folder)
    covered = [p for p, m in enumerate(studio.loaded.mask) if m > 0.5]
    rows = [("import", "", 0, round(studio.import_s, 2), "")]
    truth, _ = studio.picture(REFERENCE, REFERENCE_SEED)
    studio.picture(1)
    ways = [("cycles", False)] + ([("cycles", True)] if studio.compat.can_denoise() else [])
    for engine, denoise in ways:
        for samples in SAMPLES:
            found, seconds = studio.picture(samples, denoise=denoise)
            rows.append((engine, "denoised" if denoise else "", samples, round(seconds, 2),
                         round(psnr(found, truth, covered), 2)))
            print(*rows[-1], flush=True)
    for engine in ("BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"):
        try:
            for samples in (1, 16):
                found, seconds = studio.picture(samples, engine=engine)
                rows.append(("eevee", "", samples, round(seconds, 2), round(psnr(found, truth, covered), 2)))
                print(*rows[-1], flush=True)
        except (TypeError, RuntimeError, OSError):   # none of that name, or no display
            continue
    if large:
        studio = Studio(light, large)
        rows.append(("import large", "", 0, round(studio.import_s, 2), ""))
        for samples in (1, 16):
            rows.append(("large", "", samples, round(studio.picture(samples)[1], 2), ""))
            print(*rows[-1], flush=True)
    with open(output, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("way", "denoiser", "samples", "processor_s", "psnr_db"), *rows])


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
        found["%d bounces" % bounces] = studio.picture(EDIT_SAMPLES)[0]
    return found


COLORS = ("#7b3294", "#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7")


def chart(output, *labelled):
    lines, data = [], ""
    for entry in labelled:
        label, _, path = entry.partition("=")
        with open(path, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for way, denoiser in (("cycles", ""), ("cycles", "denoised"), ("eevee", "")):
            mine = [row for row in rows if (row["way"], row["denoiser"]) == (way, denoiser)]
            if mine:
                name = "line%d" % len(lines)
                data += "$%s << end\n%s\nend\n" % (name, "\n".join(
                    "%s %s %s" % (row["processor_s"], row["psnr_db"], row["samples"]) for row in mine))
                title = "%s, %s%s" % (label, way.capitalize(), ", denoised" if denoiser else "")
                lines.append("$%s using 1:2 with linespoints lc rgb '%s' title '%s', '' using 1:2:3 with labels offset 0,0.8 "
                             "font ',8' notitle" % (name, COLORS[len(lines) % len(COLORS)], title))
    script = ("set terminal svg size 760,420 font 'sans,11' background 'white'\nset output '%s'\nset logscale x\n"
              "set xlabel 'seconds of a processor'\nset ylabel 'PSNR, dB'\nset key bottom right\nset grid\n%s\nplot %s\n"
              % (output, data, ", ".join(lines)))
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    {"times": times, "edits": edits, "chart": chart}[arguments[0]](*arguments[1:])
    sys.stdout.flush()
    if "bpy" in sys.modules and not sys.modules["bpy"].app.binary_path:
        os._exit(0)   # some modules crash when Python ends
