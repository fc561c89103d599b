"""Folders, link graph and namespaces of the source tree, read from its CMakeLists.txt and its files."""
import re
from pathlib import Path

SOURCES = (".cpp", ".h")
# The data model's names are everybody's words.
GROUND_FLOOR = "dataset/model"
MAX_FILE_LINES, MAX_FUNCTION_LINES, MAX_PARAMETERS = 400, 60, 6


def read(path):
    return path.read_text(encoding="utf-8")


class Library:
    def __init__(self, folder, target, public, private):
        self.folder, self.target, self.public, self.private = folder, target, public, private


def libraries(root):
    """The project's folders in the order of their add_subdirectory, each with the first target that it makes."""
    found = []
    for folder in re.findall(r"add_subdirectory\(([\w/]+)\)", read(root / "CMakeLists.txt")):
        if folder == "tests":
            continue
        text = read(root / folder / "CMakeLists.txt")
        made = re.findall(r"add_(?:library|executable)\((\w+)(?! INTERFACE)", text)
        made = [name for name in made if not re.search(r"add_library\(%s INTERFACE" % name, text)]
        links = {name: {"PUBLIC": [], "PRIVATE": []} for name in made}
        for name, words in re.findall(r"target_link_libraries\(\s*(\w+)([^)]*)\)", text):
            kind = "PUBLIC"
            for word in words.split():
                if word in ("PUBLIC", "PRIVATE"):
                    kind = word
                elif name in links:
                    links[name][kind].append(word)
        for name in made:
            found.append(Library(folder, name, links[name]["PUBLIC"], links[name]["PRIVATE"]))
    return found


def reachable(library, by_target):
    """The targets whose headers a library may include: its own links, and what these hand on."""
    waiting, seen = library.public + library.private, {library.target}
    while waiting:
        target = waiting.pop()
        if target in seen:
            continue
        seen.add(target)
        if target in by_target:
            waiting += by_target[target].public
    return seen


def sources(root, folder):
    return sorted(p for p in (root / folder).iterdir() if p.suffix in SOURCES)


def folder_of(root, library_folders, path):
    parent = path.parent.relative_to(root).as_posix()
    while parent and parent != "." and parent not in library_folders:
        parent = Path(parent).parent.as_posix()
    return parent


def wrong_includes(root):
    """One line for each include of a header whose library is not linked or stands above."""
    all_of = libraries(root)
    by_target = {library.target: library for library in all_of}
    order = {}
    for i, library in enumerate(all_of):
        order.setdefault(library.folder, i)
    wrong = []
    for library in all_of:
        for target in library.public + library.private:
            if target in by_target and order[by_target[target].folder] > order[library.folder]:
                wrong.append("%s: %s links %s, which stands above it" % (library.folder, library.target, target))
    for folder in order:
        may = set().union(*(reachable(l, by_target) for l in all_of if l.folder == folder))
        may_folders = {by_target[target].folder for target in may if target in by_target} | {folder}
        for path in sources(root, folder) + sources_below(root, folder, order):
            for name in re.findall(r'#include "([^"]+)"', read(path)):
                header = root / name if (root / name).exists() else path.parent / name
                of = folder_of(root, order, header)
                if of in order and of not in may_folders:
                    wrong.append("%s: includes %s, whose library %s is not linked by %s"
                                 % (path.relative_to(root), name, of, folder))
    return wrong


def sources_below(root, folder, order):
    """Files of sub-folders that have no library of their own."""
    return sorted(p for p in (root / folder).rglob("*")
                  if p.suffix in SOURCES and p.parent != root / folder and folder_of(root, order, p) == folder)


def wrong_namespaces(root):
    """One line for each file that opens another library's namespace than its own: two types of one name in one
    program are undefined behaviour that no compiler sees."""
    wrong, owner = [], {}
    for library in libraries(root):
        for path in sources(root, library.folder):
            opened = set(re.findall(r"^namespace ohb(?:::(\w+))?(?:::\w+)* \{", read(path), re.M))
            if not opened or library.folder.endswith("/cli"):
                continue
            own = "" if library.folder == GROUND_FLOOR else owner.setdefault(library.folder, min(opened - {""}, default="?"))
            for name in opened - {own}:
                wrong.append("%s: opens namespace ohb%s, its library has ohb::%s"
                             % (path.relative_to(root), name and "::" + name, own))
    names = list(owner.values())
    wrong += ["namespace ohb::%s belongs to two libraries" % n for n in sorted(set(names)) if names.count(n) > 1]
    return wrong


TYPE = re.compile(r"^(?:struct|class|union|enum(?: class| struct)?) (?:alignas\(\w+\) )?(\w+)(?: final)?(?: :(?!:)[^;]*)? \{")


def types_of(text):
    """The qualified names of the types that a formatted C++ file defines at namespace level, but those that only it sees."""
    inside = []
    for line in text.split("\n"):
        opened = re.match(r"namespace ?([\w:]*) ?\{", line)
        if opened:
            inside.append(opened[1])
        elif line.startswith("}  // namespace"):
            inside.pop()
        elif "" not in inside and TYPE.match(line):
            yield "::".join(inside + [TYPE.match(line)[1]])


def types_of_one_name(root):
    """One line for each type that has the qualified name of another: in one program they would be undefined behaviour
    that no compiler sees. What this reading of the text misses, the linker finds (the preset "odr")."""
    found = {}
    for path, name in files_of(root):
        for qualified in types_of(read(path)) if path.suffix in SOURCES else ():
            found.setdefault(qualified, []).append(str(name))
    return ["%s is defined in %s" % (qualified, " and ".join(files))
            for qualified, files in sorted(found.items()) if len(files) > 1]


def wrong_in_readme(root):
    """One line for each library whose folder or uses README's table does not have as CMake links them."""
    all_of = libraries(root)
    folder_of_target = {library.target: library.folder for library in all_of}
    uses = {}
    for library in all_of:
        linked = uses.setdefault(library.folder, set())
        linked |= {folder_of_target[t] for t in library.public + library.private if t in folder_of_target}
    table = read(root / "README.md").split("| folder | holds | uses |")[-1].split("\n\n")[0]
    rows = re.findall(r"^\| `([\w/]+)` \|.*\| ([^|]*) ?\|$", table, re.M)
    told = {folder: set(re.findall(r"`([\w/]+)`", words)) for folder, words in rows}
    wrong = []
    for folder, linked in uses.items():
        linked.discard(folder)
        if told.get(folder) != linked:
            wrong.append("README.md: `%s` uses %s, and is said to use %s"
                         % (folder, sorted(linked), sorted(told.get(folder, {"nothing: it has no row"}))))
    return wrong


STATEMENT = re.compile(r"^( *)(?!(?:namespace|struct|class|enum|union|extern|if|for|while|switch|else|do|try|case|return|using|"
                       r"public|private|default|template|const auto|auto)\b|[}#:/])\S")
BODY = re.compile(r"\)( const| noexcept| override| final| mutable)*( -> [\w:<>]+)? \{$|\)\s*:.*\{$")


def functions(text):
    """(first line's number, lines, parameters) of each function of a formatted C++ file."""
    lines = [line.split(" //")[0].rstrip() for line in text.split("\n")]
    i, before = 0, ";"
    while i < len(lines):
        line = lines[i]
        begins = not before or before.endswith((";", "{", "}", ":", ">")) or before.lstrip().startswith(("//", "#"))
        before = line or ""
        match = STATEMENT.match(line)
        if not (begins and match):
            i += 1
            continue
        j = i
        while j + 1 < len(lines) and not lines[j].endswith((";", "{", "}")):
            j += 1
        before = lines[j]
        head = " ".join(l.strip() for l in lines[i:j + 1])
        if "(" in head and BODY.search(head) and not re.search(r"= *\[|\[[&=\w, ]*\]\s*\(|^[A-Z_]+\(", head):
            end = next((k for k in range(j + 1, len(lines)) if lines[k].startswith(match[1] + "}")), j)
            yield i + 1, end - i + 1, parameters(head)
        i = j + 1


def parameters(head):
    depth, count, inside = 0, 0, ""
    for c in head[head.index("("):]:
        depth += c in "(<[{"
        depth -= c in ")>]}"
        if depth == 0:
            break
        inside += c
        count += c == "," and depth == 1
    return count + 1 if inside[1:].strip() else 0


def files_of(root):
    for top in ("dataset", "bake", "renderer", "learner", "blender_addon", "tests"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in SOURCES + (".py",) and "__pycache__" not in path.parts:
                yield path, path.relative_to(root)


def too_long(root):
    """One line for each file and function beyond the project's limits."""
    wrong = []
    for path, name in files_of(root):
        text = read(path)
        if text.count("\n") > MAX_FILE_LINES:
            wrong.append("%s: %d lines" % (name, text.count("\n")))
        for line, count, arguments in functions(text) if path.suffix in SOURCES else ():
            if count > MAX_FUNCTION_LINES and name.parts[0] != "tests":    # where tables of cases are functions
                wrong.append("%s:%d: a function of %d lines" % (name, line, count))
            if arguments > MAX_PARAMETERS:
                wrong.append("%s:%d: a function of %d parameters" % (name, line, arguments))
    return wrong


def paths_in_definitions(root):
    """One line for each definition that holds a path of this machine: the compiler cache of another folder would miss."""
    wrong = []
    for path in sorted(root.rglob("CMakeLists.txt")):
        if path.relative_to(root).parts[0] == "build":
            continue
        for arguments in re.findall(r"(?:target_compile|add_compile|COMPILE)_DEFINITIONS?\b([^)]*\))", read(path), re.I):
            for found in re.findall(r"\w+=\S*(?:_DIR|SHARED_DATA|TARGET_FILE)\b", arguments):
                wrong.append("%s: %s" % (path.relative_to(root), found))
    return wrong


def classes_written_out(root):
    """One line for each place of the product that names all classes, or sums them by name: it would forget a new one."""
    sums = r"(\w[\w\[\]]*)\[0\] \+ \1\[1\] \+ \1\[2\] \+ \1\[3\]|\[kFabric\] \+ \S*\[kLeather\]"
    names = r'"skin".*"hair".*"fabric".*"leather"'
    return ["%s:%d: %s" % (name, k + 1, line.strip())
            for path, name in files_of(root) if name.parts[0] not in ("tests", "renderer")   # whose BSDF has four lobes
            for k, line in enumerate(read(path).splitlines())
            if re.search(sums + "|" + names, line) and name.as_posix() != "dataset/model/regions.h"]


def long_functions(root, limit):
    """One line for each function of the product above `limit` lines."""
    return ["%s:%d: %d lines" % (name, line, count)
            for path, name in files_of(root) if path.suffix in SOURCES and name.parts[0] != "tests"
            for line, count, _ in functions(read(path)) if count > limit]
