"""The page of a user study in a real browser: pairs are shown until all have met, and the choices come out as a file."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

from chromium import Browser

PROGRAM = os.environ.get("DUALPIXEL_PROGRAM", "build/release/tools/dualpixel")
SCENES = os.environ.get("DUALPIXEL_SCENES_DIR", "build/release/scenes")
METHODS = ("paper", "likelihood", "split")


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


@unittest.skipUnless(shutil.which("chromium"), "no Chromium (package chromium): pages are not tested in a browser")
class Study(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="study")
        cls.out = pathlib.Path(cls.folder.name)
        run("simulate", SCENES + "/slanted_planes.json", "-o", cls.out / "capture", "--set", "sensor.width_px=320",
            "--set", "sensor.height_px=240", "--set", "burst.frames=1", "--set", "render.samples_per_pixel=4")
        portraits = []
        for method in METHODS:
            run("portrait", cls.out / "capture", "-o", cls.out / method / "near", "--mode", "dp", "--matcher", method,
                "--match-lens", "f/1@85mm-equivalent")
            shutil.copytree(cls.out / method / "near", cls.out / method / "far")
            portraits += ["--portraits", f"{method}={cls.out / method}"]
        run("experiment", "votes", *portraits, "-o", cls.out / "study")
        cls.browser = Browser()
        cls.browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(cls.out))

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.folder.cleanup()

    def text_of(self, selector):
        return self.browser.run(f"document.querySelector('{selector}').textContent")

    def test_choices_become_votes(self):
        self.browser.open(self.out / "study" / "study.html")
        self.browser.run("document.querySelector('button').click()")
        self.assertEqual(self.browser.run("document.querySelectorAll('.choice').length"), 0)  # it waits for a name
        self.browser.run("document.getElementById('participant').value = 'Ada L.'")
        self.browser.run("document.querySelector('button').click()")
        # The browser's own keys, and the second half of a double click, choose nothing.
        self.browser.run("""document.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft', altKey: true}));
          document.querySelector('.choice').dispatchEvent(new MouseEvent('click', {detail: 2}));""")
        for scene in (1, 2):
            for pair, key in ((1, "ArrowLeft"), (2, "ArrowRight")):
                self.assertEqual(self.text_of("#study p"), f"Scene {scene} of 2, pair {pair} of 2")
                pictures = self.browser.run("""Promise.all([...document.images].map(async image => {
                  await image.decode();
                  return image.naturalWidth;
                }))""")
                self.assertEqual(pictures, 2 * ([320] + len(pictures[2:]) // 2 * [128]))
                self.browser.press(key)
        written = self.text_of("pre")
        self.browser.run("document.getElementById('save').click()")
        saved = self.out / "votes_Ada_L_.json"
        for _ in range(100):
            if saved.exists() and saved.read_text() == written:
                break
            time.sleep(0.1)
        self.assertEqual(saved.read_text(), written)
        votes = json.loads(written)
        self.assertEqual(sorted(scene["scene"] for scene in votes["scenes"]), [0, 1])
        for scene in votes["scenes"]:
            (left, _, first), (_, right, second) = scene["comparisons"]
            self.assertEqual((first, second), (left, right))  # the keys' sides
        self.assertEqual(self.browser.console, [])
        others = [url for url in self.browser.requests if not url.startswith(("data:image/jpeg", "blob:"))]
        self.assertEqual(len(others), 1, others)  # the page itself

        counted = json.loads(run("experiment", "votes", "--study", self.out / "study", saved, "--json"))
        self.assertEqual(counted["participants"], ["Ada L."])
        self.assertEqual([row["method"] for row in counted["methods"]], list(METHODS))
        self.assertEqual(sum(row["votes"][0] for row in counted["methods"]), 2)
        key = json.loads((self.out / "study" / "study.json").read_text())
        for scene in votes["scenes"]:
            winner = key["scenes"][scene["scene"]]["method_of_picture"][scene["comparisons"][-1][2]]
            self.assertGreater(counted["methods"][winner]["votes"][0], 0)


if __name__ == "__main__":
    unittest.main()
