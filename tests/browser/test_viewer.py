"""The pages' viewer in a real browser: what it shows, what its keys do, that it stays by itself.

    DUALPIXEL_PROGRAM=build/release/tools/dualpixel DUALPIXEL_SCENES_DIR=build/release/scenes \
        python3 -m unittest discover -v -s tests/browser
"""

import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import time
import unittest

from chromium import Browser

PROGRAM = os.environ.get("DUALPIXEL_PROGRAM", "build/release/tools/dualpixel")
SCENES = os.environ.get("DUALPIXEL_SCENES_DIR", "build/release/scenes")
HOSTILE = "dp</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&"  # a folder in folders
WIDTH, HEIGHT = 192, 144


def floats_of(path, channel):
    """One channel of an image file, rows of floats, by way of an uncompressed TIFF."""
    with tempfile.TemporaryDirectory() as folder:
        tiff = os.path.join(folder, "x.tif")
        subprocess.run(["oiiotool", path, "--ch", channel, "-d", "float", "--compression", "none", "--scanline",
                        "-o", tiff], check=True)
        data = pathlib.Path(tiff).read_bytes()
    order = "<" if data[:2] == b"II" else ">"
    at = struct.unpack(order + "I", data[4:8])[0]
    tags = {}
    for i in range(struct.unpack(order + "H", data[at:at + 2])[0]):
        tag, kind, count, value = struct.unpack(order + "HHII", data[at + 2 + 12 * i:at + 14 + 12 * i])
        if kind == 3 and count == 1:
            value = struct.unpack(order + "H", data[at + 10 + 12 * i:at + 12 + 12 * i])[0]
        tags[tag] = (count, value)
    width, height = tags[256][1], tags[257][1]
    count, offsets = tags[273]
    start = offsets if count == 1 else struct.unpack(order + "I", data[offsets:offsets + 4])[0]
    values = struct.unpack(f"{order}{width * height}f", data[start:start + 4 * width * height])
    return [values[width * y:width * (y + 1)] for y in range(height)]


@unittest.skipUnless(shutil.which("chromium"), "no Chromium (package chromium): pages are not tested in a browser")
class Viewer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="viewer")
        cls.out = pathlib.Path(cls.folder.name)
        capture = str(cls.out / "capture")
        run = lambda *arguments: subprocess.run([PROGRAM, *arguments], check=True, stdout=subprocess.DEVNULL)
        run("simulate", SCENES + "/slanted_planes.json", "-o", capture, "--set", f"sensor.width_px={WIDTH}",
            "--set", f"sensor.height_px={HEIGHT}", "--set", "burst.frames=1", "--set", "render.samples_per_pixel=16")
        cls.results = [str(cls.out / HOSTILE), str(cls.out / "second")]
        (cls.out / HOSTILE).parent.mkdir(parents=True)
        for result, matcher in zip(cls.results, ("paper", "likelihood")):
            run("portrait", capture, "-o", result, "--mode", "dp", "--matcher", matcher,
                "--match-lens", "f/1@85mm-equivalent")
        cls.page = str(cls.out / "report.html")
        run("report", *cls.results, "-o", cls.page)
        cls.capture = capture
        cls.browser = Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.folder.cleanup()

    def setUp(self):
        self.browser.console.clear()
        self.browser.requests.clear()
        self.open(self.page)

    def tearDown(self):
        self.assertEqual(self.browser.console, [])
        others = [url for url in self.browser.requests if not url.startswith("data:image/jpeg")]
        self.assertEqual(len(others), 1, others)  # the page itself

    def open(self, page):
        self.browser.open(page)
        self.settle(0)
        self.browser.run("document.querySelector('.viewer').scrollIntoView()")

    def settle(self, before=None, browser=None):
        """Waits until the viewer has drawn again."""
        (browser or self.browser).run("""new Promise((done, fail) => {
          const figure = document.querySelector('.viewer'), start = performance.now();
          const wait = () => Number(figure.dataset.drawn ?? 0) > %d && figure.ariaBusy === 'false' ? done()
              : performance.now() - start > 60000 ? fail(new Error('nothing was drawn')) : setTimeout(wait, 10);
          wait();
        })""" % (self.drawn() if before is None else before))

    def drawn(self):
        return self.browser.run("Number(document.querySelector('.viewer').dataset.drawn ?? 0)")

    def press(self, key):
        before = self.drawn()
        self.browser.press(key)
        self.settle(before)

    def point(self, x, y, pane=0):
        """Moves the mouse onto the middle of a pixel of the picture (the whole picture is shown)."""
        box = self.canvas_box(pane)
        before = self.drawn()
        self.browser.mouse("mouseMoved", box["x"] + (x + 0.5) / WIDTH * box["width"],
                           box["y"] + (y + 0.5) / HEIGHT * box["height"])
        self.settle(before)

    def canvas_box(self, pane=0):
        return self.browser.run(f"document.querySelectorAll('.pane canvas')[{pane}].getBoundingClientRect().toJSON()")

    def row(self, layer):
        """Of the read-out: position in the file, and the values."""
        return self.browser.run("[...document.querySelector(`.readout [data-layer='%s']`).cells].slice(1)"
                                ".map(cell => cell.textContent)" % layer)

    def label(self, pane=0):
        return self.browser.run(f"document.querySelectorAll('.pane b')[{pane}].textContent")

    def pressed(self):
        return self.browser.run("[...document.querySelectorAll('[aria-pressed=true]')].map(b => b.textContent)")

    def pixels(self, pane=0):
        """A number that changes with the picture that is shown."""
        return self.browser.run("""(() => {
          const canvas = document.querySelectorAll('.pane canvas')[%d];
          let hash = 0;
          for (const digit of canvas.toDataURL()) hash = (Math.imul(hash, 31) + digit.charCodeAt(0)) | 0;
          return hash;
        })()""" % pane)

    def test_reads_the_files_values(self):
        maps = {"Disparity": floats_of(self.results[0] + "/maps.exr", "disparity_dp_px"),
                "Confidence": floats_of(self.results[0] + "/maps.exr", "confidence"),
                "Blur radius": floats_of(self.results[0] + "/maps.exr", "blur_radius_px"),
                "True disparity": floats_of(self.capture + "/truth/geometry.exr", "disparity_dp_px")}
        steps = {"Disparity": 1 / 1024, "True disparity": 1 / 1024, "Confidence": 1 / 256, "Blur radius": 1 / 16}
        views = {name: floats_of(f"{self.capture}/frames/000_{side}.png", "0")
                 for name, side in (("Left view", "left"), ("Right view", "right"))}
        for x, y in ((0, 0), (WIDTH - 1, HEIGHT - 1), (50, 70), (101, 33), (150, 120)):
            self.point(x, y)
            for name, values in maps.items():
                position, value = self.row(name)
                self.assertEqual(position, f"{x}, {y}")
                # half a step, and half of the last digit, which is smaller than a step
                self.assertLessEqual(abs(float(value) - values[y][x]), steps[name], (name, x, y))
            error = float(self.row("Error")[1])
            self.assertLessEqual(abs(error - (maps["Disparity"][y][x] - maps["True disparity"][y][x])), 2 / 1024)
            for name, values in views.items():
                position, value = self.row(name)
                self.assertEqual(position, f"{x // 2}, {y // 4}")
                self.assertEqual(int(value), round(values[y // 4][x // 2] * 65535), (name, x, y))

    def test_a_screenshot_shows_the_files_values(self):
        confidence = floats_of(self.results[0] + "/maps.exr", "confidence")
        self.press("9")
        shot = str(self.out / "confidence.png")
        self.browser.screenshot(shot)
        codes = floats_of(shot, "0")
        box = self.canvas_box()
        compared = 0
        for y in range(8, HEIGHT):  # the layer's name covers the rows above
            for x in range(WIDTH):
                row = int(box["y"] + (y + 0.5) / HEIGHT * box["height"])
                column = int(box["x"] + (x + 0.5) / WIDTH * box["width"])
                if row >= len(codes):  # below the window
                    continue
                compared += 1
                # gray from 0 to 1: half a step of the page's 1/256, and half a code
                self.assertLessEqual(abs(codes[row][column] - confidence[y][x]), 0.5 / 256 + 0.5 / 255 + 1e-6, (x, y))
        self.assertGreater(compared, WIDTH * HEIGHT / 2)

    def test_keys_show_every_layer(self):
        names = self.browser.run("[...document.querySelectorAll('.choices')[0].children].map(b => b.lastChild.data)")
        self.assertEqual(names, ["Left view", "Right view", "Picture", "Portrait", "True photograph", "Disparity",
                                 "True disparity", "Error", "Confidence", "Blur radius", "Error after fit"])
        seen = set()
        for i, name in enumerate(names[:10]):
            self.press(str((i + 1) % 10))
            self.assertTrue(self.label().startswith(name + " · "), self.label())
            seen.add(self.pixels())
        self.assertEqual(len(seen), 10)  # no two alike
        self.press(".")
        self.assertTrue(self.label().startswith("Error after fit"))
        self.press(",")
        self.assertTrue(self.label().startswith("Blur radius"))

    def test_results_flip_in_place_and_stand_side_by_side(self):
        self.press("6")
        first = self.pixels()
        self.press("]")
        self.assertEqual(self.label(), "Disparity · second")
        second = self.pixels()
        self.assertNotEqual(first, second)
        self.press("[")
        self.assertEqual(self.pixels(), first)
        self.press("s")
        self.assertEqual(self.browser.run("document.querySelectorAll('.pane').length"), 2)
        self.assertEqual(self.label(1), "Disparity · second")
        self.point(60, 60, pane=1)
        self.assertEqual(len(self.row("Disparity")), 3)
        self.press("+")
        self.assertNotEqual(self.pixels(0), self.pixels(1))
        boxes = self.browser.run("""[...document.querySelectorAll('.viewer')].map(f => f.className)""")
        self.assertIn("zoomed", boxes[0])

    def test_zoom_and_move_keep_the_point_under_the_pointer(self):
        self.press("3")
        whole = self.pixels()
        self.point(120, 40)
        before = self.row("True disparity")
        for key in "++++":
            self.press(key)
        self.assertEqual(self.row("True disparity"), before)
        zoomed = self.pixels()
        self.assertNotEqual(zoomed, whole)
        for there, back in (("ArrowLeft", "ArrowRight"), ("ArrowUp", "ArrowDown")):
            self.press(there)
            self.assertNotEqual(self.pixels(), zoomed)
            self.press(back)
            self.assertEqual(self.pixels(), zoomed)
        self.press("f")
        self.assertEqual(self.pixels(), whole)
        box = self.canvas_box()
        x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 3
        for kind, buttons in (("mousePressed", 1), ("mouseReleased", 0)):  # focus, so that the wheel zooms
            self.browser.mouse(kind, x, y, button="left", buttons=buttons, clickCount=1)
        drawn = self.drawn()
        self.browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-400)
        self.settle(drawn)
        self.assertNotEqual(self.pixels(), whole)
        drag = self.pixels()
        self.browser.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        drawn = self.drawn()
        self.browser.mouse("mouseMoved", x - 40, y, button="left", buttons=1)
        self.settle(drawn)
        self.browser.mouse("mouseReleased", x - 40, y, button="left")
        self.assertNotEqual(self.pixels(), drag)

    def test_compares_two_layers(self):
        self.press("6")
        plain = self.pixels()
        self.assertEqual(self.browser.run("document.querySelector('.viewer select').value"), "True disparity")
        self.press("d")
        self.assertTrue(self.label().startswith("Disparity − True disparity"))
        self.assertNotEqual(self.pixels(), plain)
        self.press("w")
        self.assertIn("wWipe", self.pressed())
        self.assertNotEqual(self.pixels(), plain)
        self.press("b")
        labels = set()
        until = time.monotonic() + 60
        while len(labels) < 2 and time.monotonic() < until:
            labels.add(self.label().split(" · ")[0])
        self.assertEqual(labels, {"Disparity", "True disparity"})
        self.press("b")
        self.assertEqual(self.pixels(), plain)

    def test_exposure_scale_and_reset(self):
        for key in "46":
            self.press(key)
            plain = self.pixels()
            self.press("e")
            self.assertNotEqual(self.pixels(), plain)
            self.press("q")
            self.assertEqual(self.pixels(), plain)
            self.press("q")
            self.assertNotEqual(self.pixels(), plain)
            self.press("r")
            self.assertEqual(self.pixels(), plain)
        high = self.browser.run("document.querySelector('.scale').lastChild.textContent")
        self.press("e")
        self.press("e")  # two half stops: half the scale
        half = self.browser.run("document.querySelector('.scale').lastChild.textContent")
        self.assertAlmostEqual(float(half.split()[0]), float(high.split()[0]) / 2, places=6)
        self.assertTrue(half.endswith("DP px"))

    def test_worst_region_is_where_the_error_is_largest(self):
        estimate = floats_of(self.results[0] + "/maps.exr", "disparity_dp_px")
        truth = floats_of(self.capture + "/truth/geometry.exr", "disparity_dp_px")
        valid = floats_of(self.capture + "/truth/geometry.exr", "valid")
        def mean(i, j):  # of a block; none where the truth is not known in most of it
            errors = [abs(estimate[y][x] - truth[y][x]) for y in range(6 * j, 6 * j + 6)
                      for x in range(6 * i, 6 * i + 6) if valid[y][x] == 1]
            return sum(errors) / len(errors) if len(errors) >= 9 else 0

        worst = max(mean(i, j) for j in range(24) for i in range(32))
        shown, title = self.browser.run("(b => [b.textContent, b.title])(document.querySelector('.worst button'))")
        x, y = [int(part) for part in title.removeprefix("at ").split(", ")]
        self.assertGreaterEqual(mean(x // 6, y // 6), worst - 2 / 1024)  # both maps are rounded to half of 1 / 1024
        self.assertAlmostEqual(float(shown), worst, delta=0.05 * worst + 1 / 1024)  # two digits
        drawn = self.drawn()
        self.browser.run("document.querySelector('.worst button').click()")
        self.settle(drawn)
        self.assertIn("zoomed", self.browser.run("document.querySelector('.viewer').className"))

    def test_profile_shows_estimates_and_truth(self):
        self.press("6")
        self.press("p")
        self.assertEqual(self.browser.run("document.querySelectorAll('.profile polyline').length"), 3)
        title = self.browser.run("document.querySelector('.profile').textContent")
        self.assertIn(f"along {WIDTH} pixels from 0, {HEIGHT // 2} to {WIDTH}, {HEIGHT // 2}", title)
        self.press("p")
        self.assertTrue(self.browser.run("document.querySelector('.profile').hidden"))

    def test_escapes_hostile_names(self):
        self.assertEqual(self.browser.run("document.querySelectorAll('img[src=x]').length"), 0)
        self.assertIn(HOSTILE, self.label())
        results = self.browser.run("document.querySelectorAll('.choices')[1].textContent")
        self.assertIn(HOSTILE, results)

    def test_says_nothing_of_the_machine(self):
        self.assertNotIn(self.folder.name, pathlib.Path(self.page).read_text())

    def test_tables_sort(self):
        column = ("(head => [...head.closest('table').rows].slice(1).map(row => parseFloat(row.cells[head.cellIndex]"
                  ".textContent)))(document.querySelectorAll('h4 + table th, .scroll th')[%d])")
        heads = self.browser.run("[...document.querySelector('.scroll table').rows[0].cells].map(c => c.textContent)")
        total = heads.index("total, ms")
        for order in (1, -1):
            self.browser.run("document.querySelector('.scroll table').rows[0].cells[%d].firstChild.click()" % total)
            values = self.browser.run(column % total)
            self.assertEqual(values, sorted(values, reverse=order < 0))

    def test_other_pictures_are_enlarged(self):
        page = str(self.out / "lens.html")
        if not os.path.exists(page):
            subprocess.run([PROGRAM, "lens", SCENES + "/../lens_models/phone_thin_4.4mm_f1.8.json", "-o", page],
                           check=True, stdout=subprocess.DEVNULL)
        self.browser.requests.clear()
        self.browser.open(page)
        large, title = "document.querySelector('.enlarged img')", "document.querySelector('.enlarged span').textContent"
        captions = self.browser.run("[...document.querySelectorAll('figure:has(img) figcaption')].map(c => c.textContent)")
        self.assertGreater(len(captions), 1)
        self.browser.run("document.querySelector('img[role=button]').focus()")
        self.browser.press("Enter")
        self.assertTrue(self.browser.run("document.querySelector('.enlarged').open"))
        self.assertEqual(self.browser.run(title), captions[0] + ": left view")
        self.browser.press("ArrowLeft")  # from the first to the last
        self.assertEqual(self.browser.run(title), captions[-1] + ": right view")
        # the pixel under the pointer, as a canvas of the picture's own size has it
        x, y, codes = self.browser.run(f"""(async () => {{
          const image = {large}, box = image.getBoundingClientRect(), canvas = document.createElement('canvas');
          await image.decode();
          canvas.width = image.naturalWidth;
          canvas.height = image.naturalHeight;
          const context = canvas.getContext('2d'), scale = Math.min(box.width / canvas.width, box.height / canvas.height);
          context.drawImage(image, 0, 0);
          const column = Math.floor(canvas.width / 3), row = Math.floor(canvas.height / 2);
          return [box.left + (box.width - canvas.width * scale) / 2 + (column + 0.5) * scale,
                  box.top + (box.height - canvas.height * scale) / 2 + (row + 0.5) * scale,
                  `${{column}}, ${{row}}: ${{[...context.getImageData(column, row, 1, 1).data].slice(0, 3).join(' ')}}`];
        }})()""")
        self.browser.mouse("mouseMoved", x, y)
        readout = "document.querySelector('.enlarged .readout').textContent"
        self.assertEqual(self.browser.run("""new Promise((done, fail) => {
          const readout = document.querySelector('.enlarged .readout'), start = performance.now();
          const wait = () => readout.textContent ? done(readout.textContent)
              : performance.now() - start > 60000 ? fail(new Error('nothing was read out')) : setTimeout(wait, 10);
          wait();
        })"""), codes)
        self.browser.press("+")  # about the window's middle: another pixel comes under the pointer
        self.assertNotEqual(self.browser.run(readout).split(":")[0], codes.split(":")[0])
        self.browser.press("f")
        self.assertEqual(self.browser.run(readout), codes)
        # twice as large, about the pointer
        self.browser.mouse("mouseWheel", 300, 200, deltaX=0, deltaY=-240)
        box = self.browser.run(f"(({{left, top, width}}) => [left, top, width / document.documentElement.clientWidth])"
                               f"({large}.getBoundingClientRect())")
        for seen, expected in zip(box, (-300, -200, 2)):
            self.assertAlmostEqual(seen, expected, delta=1e-3)
        self.browser.run("document.activeElement.blur()")  # as a click may
        self.browser.press("f")
        self.assertEqual(self.browser.run(f"{large}.getBoundingClientRect().left"), 0)
        self.browser.run("document.querySelector('.enlarged button').click()")
        self.assertFalse(self.browser.run("document.querySelector('.enlarged').open"))

    def test_fits_a_phone_and_names_what_it_shows(self):
        with Browser(width=390, height=844, dark=True, mobile=True) as phone:
            phone.open(self.page)
            self.settle(0, phone)
            self.assertLessEqual(phone.run("document.documentElement.scrollWidth"), 390)
            self.assertEqual(phone.run("[...document.querySelectorAll('button, canvas[role=img], select, input')]"
                                       ".filter(e => !(e.textContent || e.ariaLabel || e.labels?.length)).length"), 0)
            self.assertEqual(phone.console, [])


if __name__ == "__main__":
    unittest.main()
