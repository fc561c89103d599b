"""Every relative link of the documentation leads to a file that is there, and to a heading that it has.

usage: links_test.py SOURCE_FOLDER [unittest's arguments]
"""
import re
import sys
import tempfile
import unittest
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^ *(```|~~~).*?^ *\1[ \t]*$", re.M | re.S)
LINK = re.compile(r"\]\(([^()\s]+)\)")


def pages(root):
    found = [root / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")]
    found += sorted((root / "docs").rglob("*.md")) + sorted((root / "assets").rglob("*.md"))
    return [page for page in found if page.exists()]


def anchors(page):
    """The names that GitHub gives to a page's headings."""
    names, seen = set(), {}
    for heading in re.findall(r"^#+ +(.+?) *#*$", FENCE.sub("", page.read_text(encoding="utf-8")), re.M):
        heading = re.sub(r"\]\([^)]*\)", "]", heading)
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        seen[name] = seen.get(name, -1) + 1
        names.add(name if seen[name] == 0 else "%s-%d" % (name, seen[name]))
    return names


def broken_links(root):
    """One line for each link that leads nowhere."""
    wrong = []
    for page in pages(root):
        text = re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
        for link in LINK.findall(text):
            if re.match(r"[a-z][a-z+.-]*:", link):
                continue
            name, _, anchor = unquote(link).partition("#")
            target = (page.parent / name).resolve() if name else page
            if not target.exists():
                wrong.append("%s: %s is not there" % (page.relative_to(root), link))
            elif anchor and anchor not in anchors(target):
                wrong.append("%s: %s has no heading #%s" % (page.relative_to(root), name or page.name, anchor))
    return wrong


def not_in_contents(root):
    """One line for each page of docs that docs/README.md does not link; tests/cli looks after those of the commands."""
    contents = root / "docs/README.md"
    linked = {(contents.parent / link.partition("#")[0]).resolve() for link in LINK.findall(contents.read_text(encoding="utf-8"))}
    return ["docs/README.md does not list %s" % page.relative_to(root)
            for page in sorted((root / "docs").rglob("*.md"))
            if page != contents and page.parent.name != "commands" and page.resolve() not in linked]


class Documentation(unittest.TestCase):
    def nothing(self, lines):
        self.assertFalse(lines, "\n" + "\n".join(lines))

    def test_links_lead_somewhere(self):
        self.nothing(broken_links(ROOT))

    def test_contents_list_every_page(self):
        self.nothing(not_in_contents(ROOT))


class Planted(unittest.TestCase):
    """A small tree of pages that is in order, with one fault at a time."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name).resolve()
        self.write("README.md", "# Top\n[b](docs/b.md#two-words-of-v2), [web](https://x.org/no), [here](#top)\n")
        self.write("docs/README.md", "[b](b.md)\n")
        self.write("docs/b.md", "# B\n## Two words, of `v2`\n```\n[not a link](nowhere.md)\n```\n")

    def write(self, name, text):
        (self.root / name).parent.mkdir(exist_ok=True)
        (self.root / name).write_text(text, encoding="utf-8")

    def test_a_tree_in_order_is_clean(self):
        self.assertEqual(broken_links(self.root) + not_in_contents(self.root), [])

    def test_a_file_that_is_not_there(self):
        self.write("docs/README.md", "[b](b.md) [c](c.md)\n")
        self.assertEqual(broken_links(self.root), ["docs/README.md: c.md is not there"])

    def test_a_heading_that_is_not_there(self):
        self.write("CHANGELOG.md", "[b](docs/b.md#three)\n")
        self.assertEqual(broken_links(self.root), ["CHANGELOG.md: docs/b.md has no heading #three"])

    def test_a_page_that_the_contents_do_not_list(self):
        self.write("docs/d.md", "# D\n")
        self.assertEqual(not_in_contents(self.root), ["docs/README.md does not list docs/d.md"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
