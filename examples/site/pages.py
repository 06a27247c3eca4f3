"""Usage: python3 examples/site/pages.py FOLDER
          python3 examples/site/pages.py --finish FOLDER

Writes the input of Doxygen to FOLDER: the public headers with comments in Doxygen's syntax, the pages of
this folder, a page per lesson, the gallery, the README of each room, and the layout of the menu.
--finish: edits the HTML output of Doxygen.
"""
import os
import re
import shutil
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SITE = "examples/site"
SOLVERS = ("grid/",)  # internal headers of these rooms are not shown, except types/
# Other languages and programs in the order of the menu: the page, its name in the menu, and its README.
LANGUAGES = [
    ("c", "C", "include/cageform/c/README.md"), ("python", "Python", "examples/bindings/python/README.md"),
    ("npm", "JavaScript", "examples/bindings/npm/README.md"), ("csharp", "C#", "examples/bindings/csharp/README.md"),
    ("blender", "Blender", "examples/integrations/blender/README.md"), ("packaging", "vcpkg, Conan", "examples/integrations/packaging/README.md"),
]


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


# What each room does, from the floor plan of the README, without marks of code.
ROOMS = {room: words.replace("`", "").strip() for room, words in
         re.findall(r"^\| \[`(\w+)/`\]\(include/[^|]* \| ([^;|]*).*\|$", read("README.md"), flags=re.M)}


def files(folder, ending):
    path = os.path.join(ROOT, folder)
    return sorted(name for name in os.listdir(path) if name.endswith(ending)) if os.path.isdir(path) else []


def types():
    """Returns the headers of coordinate types, which are also the names of their pages, and the titles of the pages."""
    headers = re.findall(r"#include <cageform/coordinates/(\w+)\.hpp>", read("include/cageform/coordinates/types.hpp"))
    return [(header, re.match(r"# (.*)", read("%s/%s.md" % (SITE, header)))[1].replace(" coordinates", "")) for header in headers]


# ---- headers -----------------------------------------------------------------------------------

def escaped(text):
    """Escapes the text of a comment for Doxygen, except `code`."""
    parts = re.split(r"(`[^`]*`)", text)
    for n in range(0, len(parts), 2):
        parts[n] = re.sub(r"([\\@<]|(?<!\w)\*(?!\w[\w -]*\*)|(?<=\s)\*)", r"\\\1", parts[n])
        parts[n] = re.sub(r"#(?=\w)", r"\\#", parts[n])
        # Abbreviations that do not end a sentence; letters outside ASCII, which Doxygen does not treat as letters.
        parts[n] = re.sub(r"\b(al|sec|eq|fig|Adv|Comput|Math|Trans)\. ", r"\1.\\ ", parts[n])
        parts[n] = re.sub(r"(?<=[^\x00-\x7f])_|_(?=[^\x00-\x7f])", r"\\_", parts[n])
    return "".join(parts)


def definition_table(lines):
    """Converts lines "name  description", with indented continuation lines, to HTML; None for other lines."""
    rows = []
    for line in lines:
        entry = re.match(r"(\S+(?: \S+)*)(?:  +(\S.*))?$", line)
        if entry:
            rows.append([entry[1], [entry[2]] if entry[2] else []])
        elif rows:
            rows[-1][1].append(line.strip())
    first = rows[0]
    if not first[1] or " = " in first[0] or "," == first[0][-1] or lines[0].startswith(("#", "|")):
        return None
    # A line without a description continues the previous entry.
    merged = []
    for name, text in rows:
        if text or not merged:
            merged.append([name, text])
        else:
            merged[-1][1].append(name)
    cells = ["<dt>%s</dt><dd>%s</dd>" % (escaped(name), escaped(" ".join(text))) for name, text in merged]
    return [" <dl class=\"facts\">"] + [" " + cell for cell in cells] + [" </dl>"]


def comment(lines):
    """Converts the lines of a comment, without their slashes, to Doxygen's syntax."""
    out = []
    n = 0
    while n < len(lines):
        indent = len(lines[n]) - len(lines[n].lstrip())
        if not lines[n].strip() or indent < 3 or re.match(r"\s*[-*] |\s*\d+\. ", lines[n]):
            out.append(escaped(lines[n]))
            n += 1
            continue
        end = n + 1
        while end < len(lines) and (re.match(r" {3}", lines[end]) or (
                not lines[end].strip() and indent > 3 and end + 1 < len(lines) and
                re.match(r" {4}", lines[end + 1]))):
            end += 1
        block = [line[indent:] if line[:indent].isspace() else line.strip() for line in lines[n:end]]
        table = definition_table(block) if indent <= 4 else None
        if table:
            out += table
        else:
            is_code = any(re.search(r";$|\w\(|::|#(include|version)", line) for line in block) and indent > 3
            out += [" ```cpp" if is_code else " ```text"] + [" " + line for line in block] + [" ```"]
        n = end
    return out


def in_room(text, room):
    """Adds the declarations of a header to the Doxygen group of its room."""
    begin = "\n/// \\addtogroup room_%s\n/// @{\n" % room
    text = text.replace("namespace cageform::inline CAGEFORM_ABI", "namespace cageform")
    text = re.sub(r"^namespace [\w:]+ \{$", lambda m: m[0] + begin, text, flags=re.M)
    return re.sub(r"^} // namespace [\w:]+$", lambda m: "/// @}\n" + m[0], text, flags=re.M)


def enumerators(text):
    """Replaces macros that list enumerators by the enumerators, with the texts of the list as comments."""
    macros = dict(re.findall(r"#define (CAGEFORM_\w+)\(X\)(.*?)// clang-format on", text, flags=re.S))

    def body(found):
        named = re.findall(r'X\((\w+),[^"]*"([^"]*)"(?:,[\s\\]*"([^"]*)")?', macros[found[2]])
        return found[1] + " {\n" + "\n".join("    %s, ///< %s" % (name, escaped(more or says)) for name, says, more in named) + "\n};"

    text = re.sub(r"(enum class (?:\[\[nodiscard\]\] )?\w+ : std::uint\d+_t) *\{\n#define .*?\n +(CAGEFORM_\w+)\(.*?\n};", body, text, flags=re.S)
    return re.sub(r"(?://[^\n]*\n)*// clang-format off\n#define CAGEFORM_\w+\(X\).*?// clang-format on\n", "", text, flags=re.S)


def without_machinery(text):
    """Removes what users do not call: namespaces detail, private members, and deleted overloads."""
    for name in ("detail", "cageform::inline CAGEFORM_ABI::detail"):
        whole = r"^namespace %s \{\n.*?^} // namespace [^\n]*detail\n" % name
        text = re.sub(whole, "", text, flags=re.M | re.S)
    text = re.sub(r"^ *template <(?:(?!template <)[^;])*?CAGEFORM_DETAIL_DELETE_\w+;\n", "", text, flags=re.M)
    text = re.sub(r"^( *)(?:private|protected):\n.*?(?=^\1(?:public:|\};))", "", text, flags=re.M | re.S)
    return re.sub(r"\[\[nodiscard\]\] ", "", text)


def doxygen_header(path):
    text = read("include/cageform/" + path)
    if "(X) " in text:
        text = enumerators(text)
    text = without_machinery(text)
    out, lines = [], text.split("\n")
    n = 0
    head = True
    while n < len(lines):
        slashes = r"^(\s*)///?(?!/)(.*)$" if head else r"^(\s*)///(?![/<])(.*)$"
        found = re.match(slashes, lines[n])
        if not found:
            if lines[n].startswith("#pragma once"):
                head = False
            elif re.search(r"///<", lines[n]) or (out and re.match(r"\s*///<", lines[n])):
                before, after = lines[n].split("///<", 1)
                out.append(before + "///<" + escaped(after))
            else:
                out.append(lines[n])
            n += 1
            continue
        end = n
        block = []
        while end < len(lines) and re.match(slashes, lines[end]):
            block.append(re.match(slashes, lines[end])[2])
            end += 1
        is_ready = any(re.match(r" [@\\](name|\{|\}|addtogroup)", line) for line in block)
        made = block if is_ready else comment(block)
        if head:
            made = [" \\file"] + made
        out += [found[1] + "///" + line for line in made]
        if head:
            out.append("")
        n = end
    room = path.split("/")[0] if "/" in path else "core"
    return in_room("\n".join(out), room)


def public_headers():
    """Returns the headers that users include, and the internal headers that declare public names."""
    public = files("include/cageform", ".hpp")
    for room in ROOMS:
        public += [room + "/" + name for name in files("include/cageform/" + room, ".hpp")]
    used = set()
    for path in public:
        if not path.startswith(SOLVERS):
            code = re.sub(r"//[^\n]*", "", without_machinery(read("include/cageform/" + path)))
            used.update(re.findall(r"\b[A-Z]\w+", code))
    more = []
    root = os.path.join(ROOT, "include/cageform")
    for folder, _, names in sorted(os.walk(root)):
        for name in sorted(names):
            path = os.path.relpath(os.path.join(folder, name), root)
            if name.endswith(".hpp") and path not in public and (
                    "/types/" in path or not path.startswith(SOLVERS)):
                text = without_machinery(read("include/cageform/" + path))
                declared = re.findall(r"^(?:enum class|struct|class) (\w+)[^;\n]*\{", text, flags=re.M)
                if used.intersection(declared):
                    more.append(path)
    return public, more


# ---- pages -------------------------------------------------------------------------------------

def check_paths(name, text):
    """Fails if a page names a missing header or file; the page Changes may name old ones."""
    text = re.sub(r"^\|[^|]*\|", "", text, flags=re.M) if name == "CHANGELOG.md" else text
    for path in re.findall(r"`(?:cageform/)?((?:%s)/[\w/]+\.hpp)`" % "|".join(ROOMS), text):
        if path == path.lower() and not os.path.exists(os.path.join(ROOT, "include/cageform", path)):
            sys.exit("%s: no header %s" % (name, path))
    for path in re.findall(r"`((?:tests|examples|bench|cmake)/[\w./]+)`", text):
        if not os.path.exists(os.path.join(ROOT, path)):
            sys.exit("%s: no file %s" % (name, path))


def label_of(path):
    """Returns the name of the page of a file of the repository; None if it has no page."""
    room = re.match(r"include/cageform/(\w+)(?:/README\.md)?$", path)
    if room and room[1] in ROOMS:
        return "room_" + room[1]
    lesson = re.match(r"examples/lessons/(\d\d)_\w+\.cpp$", path)
    if lesson:
        return "lesson_" + lesson[1]
    for label, _, readme in LANGUAGES:
        if path in (readme, os.path.dirname(readme)):
            return label
    page = re.match(SITE + r"/(\w+)\.md$", path)
    if page:
        return page[1] if page[1] != "index" else "index"
    return {
        "README.md": "index", "CHANGELOG.md": "changes", "examples/README.md": "gallery", "examples": "gallery",
        "examples/programs/README.md": "programs", "examples/sources/README.md": "sources",
        "bench/README.md": "speed", "bench": "speed", "examples/page/README.md": "play", "examples/lessons": "lessons",
    }.get(path)


def relinked(text, folder, headers):
    """Converts links between files of the repository to links between pages; removes links to other files."""
    def link(found):
        bang, words, target = found[1], found[2], found[3]
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        if target.startswith("@"):
            return "\\ref %s \"%s\"" % (target[1:], words)
        path = os.path.normpath(os.path.join(folder, target.split("#")[0])).replace(os.sep, "/")
        if bang:
            return "![%s](%s)" % (words, os.path.basename(path))
        if path.startswith("include/cageform/") and path[len("include/cageform/"):] in headers:
            return "\\ref %s \"%s\"" % (path[len("include/"):], words.replace("`", "").strip())
        label = label_of(path)
        if label:
            return "\\ref %s \"%s\"" % (label, words.replace("`", "").strip().replace("\\", ""))
        if path.startswith("examples/pictures/"):
            return "<a href=\"%s\">%s</a>" % (os.path.basename(path), words)
        return words
    def replaced(found):
        if found[0].startswith("`"):  # code stays
            return found[0]
        return link(found) if found[3] else "\\" + found[0]

    return re.sub(r"```.*?```|(!?)\[((?:`[^`]*`|[^\]\[`])*)\]\(([^)\s]+)\)|`[^`]+`"
                  r"|(?<![{#&\\])#(?=\w)|@(?=[a-z0-9])|<(?=[A-Z])", replaced, text, flags=re.S)


def readme_code():
    """Returns the README's first program and its output."""
    text = read("README.md")
    code = re.search(r"```cpp\n.*?```", text, flags=re.S)[0]
    printed = re.search(r"```text\n.*?```", text[text.index(code):], flags=re.S)[0]
    return code + "\n\nprints\n\n" + printed


def type_table():
    """Returns the README's table of coordinate types, with links to their pages."""
    table = re.search(r"\| type \| cage \|.*?\n\n", read("README.md"), flags=re.S)[0]
    for header, title in types():
        name = "`%sCoordinates`" % "".join(word.capitalize() for word in header.split("_"))
        if name not in table:
            sys.exit("README.md: the table of coordinate types has no " + name)
        table = table.replace(name, "\\ref %s \"%s\"" % (header, title))
    return table


def play():
    """Returns the interactive page if it has been built; else its picture."""
    if os.path.exists(os.path.join(ROOT, "out/cageform.html")):
        frame = "<iframe class=\"play\" src=\"cageform.html\" title=\"Play\"></iframe>"
        return "\\htmlonly %s\\endhtmlonly\n\n<a href=\"cageform.html\">Open it in a separate tab</a>." % frame
    return ("![The cat, dragged by pins on its head, a paw, its tail](page.png)\n\nThis site was built without the "
            "page: `sh examples/site/run.sh --with-page` builds the page first, in some minutes.")


def header_table(room, public):
    """Returns a table of the headers of a room that users include, each with the first sentence of its comment."""
    rows = []
    for path in public:
        if path.startswith(room + "/"):
            words = []
            for line in read("include/cageform/" + path).split("\n"):
                if not line.startswith("// "):
                    break
                words.append(line[3:])
            sentence = re.match(r".*?(?:\.(?= |$)|:(?= |$)|$)", " ".join(words))[0].rstrip(":.")
            rows.append("| \\ref cageform/%s \"%s\" | %s |" % (path, path.split("/")[1], escaped(sentence)))
    return "\n\n<h2>Headers</h2>\n\n| header | contents |\n|---|---|\n" + "\n".join(rows) + "\n"


def lesson_page(name, before, after):
    lines = read("examples/lessons/" + name).rstrip("\n").split("\n")
    head = []
    while lines and lines[0].startswith("//"):
        head.append(lines.pop(0)[2:].strip())
    printed = []
    while lines and lines[-1].startswith("//>"):
        printed.insert(0, lines.pop()[4:])
    tail = []
    while lines and lines[-1].startswith("//"):
        tail.insert(0, lines.pop()[2:].strip())
    number, words = re.match(r"(\d+)\. (.*)", " ".join(head)).groups()
    title, _, rest = re.match(r"(.*?)([.:])(?: |$)(.*)", words).groups()
    page = "# Lesson %s. %s {#%s}\n\n" % (number, title, label_of("examples/lessons/" + name))
    page += "%s\n\n" % (rest[:1].upper() + rest[1:])
    page += "```cpp\n%s\n```\n\n" % "\n".join(lines).strip("\n")
    if tail:
        page += " ".join(tail) + "\n\n"
    if printed:
        page += "Output:\n\n```text\n%s\n```\n\n" % "\n".join(printed)
    page += "The source is `examples/lessons/%s`.\n\n" % name
    turn = ["\\ref %s \"← before\"" % before] if before else []
    turn += ["\\ref lessons \"all lessons\""]
    turn += ["\\ref %s \"next →\"" % after] if after else []
    page += "<div class=\"turn\">" + " · ".join(turn) + "</div>\n"
    return "%s. %s" % (number, title), title, rest, page


LESSONS = """# Lessons

Each lesson is a program of about 80 lines or fewer with one new idea, in the order of the data flow. The
printed output is tested. `sh examples/run.sh --build-only` builds them into `build/examples/`.

%s
"""
ROOMS_PAGE = """# Rooms

A game includes the rooms of run time; all other rooms prepare data for them. A room includes only rooms to its
left:

```text
run time     core → clip → figure → clone → pose
before       core, parallel → cage → grid → coordinates → binding     grid → fields     grid → enclose     clip → animate
```

| room | contents |
|---|---|
%s

Every class and function is on the page of its room, with the header to include.
"""
LAYOUT = """<doxygenlayout version="1.0"><navindex>%s</navindex>
<group><briefdescription visible="no"/><detaileddescription title=""/>
<memberdecl><nestedgroups/><concepts/><classes/><namespaces/><defines/><typedefs/><enums/><functions/>
<variables/><membergroups/></memberdecl>
<memberdef><pagedocs/><inlineclasses/><defines/><typedefs/><enums/><enumvalues/><functions/>
<variables/></memberdef></group>
<class><includes visible="yes"/><briefdescription visible="no"/><detaileddescription title=""/>
<inheritancegraph visible="no"/><memberdecl><nestedclasses/><publictypes/><publicmethods/>
<publicstaticmethods/><publicattributes/><publicstaticattributes/><related title=""/><membergroups/>
</memberdecl><memberdef><inlineclasses/><typedefs/><enums/><constructors/><functions/><related/>
<variables/></memberdef><allmemberslink visible="no"/><usedfiles visible="no"/></class>
<file><briefdescription visible="no"/><detaileddescription title=""/><includes visible="no"/>
<memberdecl><classes/><namespaces/><concepts/><defines/><typedefs/><enums/><functions/><variables/>
<membergroups/></memberdecl><memberdef><defines/></memberdef></file>
<concept><includes/><definition visible="yes" title=""/><detaileddescription title=""/></concept>
</doxygenlayout>"""


def layout(lessons):
    """Writes the menu and the order of sections on the pages of rooms and classes."""
    def tabs(entries):
        tab = "<tab type=\"user\" url=\"@ref %s\" title=\"%s\"/>"
        return "".join(tab % (url, title.replace("&", "&amp;")) for url, title in entries)
    menu = "<tab type=\"mainpage\" visible=\"no\"/>"
    menu += "<tab type=\"usergroup\" url=\"@ref coordinates\" title=\"Coordinates\">%s</tab>" % tabs(
        [("coordinates", "Which one?")] + types())
    menu += "<tab type=\"usergroup\" url=\"@ref lessons\" title=\"Lessons\">%s</tab>" % tabs(lessons)
    menu += tabs([("gallery", "Gallery"), ("programs", "Programs"), ("sources", "Sources"), ("play", "Play"), ("speed", "Speed")])
    menu += "<tab type=\"usergroup\" url=\"@ref rooms\" title=\"Reference\">%s%s</tab>" % (
        tabs([("rooms", "Rooms")] + [("room_" + room, room) for room in ROOMS]),
        "<tab type=\"classlist\" title=\"Classes\"/><tab type=\"namespacemembers\" title=\"All names\"/>")
    menu += "<tab type=\"usergroup\" url=\"@ref languages\" title=\"Languages\">%s</tab>" % tabs(
        [("languages", "All")] + [(label, name) for label, name, _ in LANGUAGES])
    menu += tabs([("engines", "For engines"), ("changes", "Changes")])
    return LAYOUT % menu


def main(out):
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)

    def write_page(label, text):
        """Writes Markdown that begins with "# title" as a comment, because Doxygen would list a Markdown file as a header."""
        command = "\\mainpage" if label == "index" else "\\page " + label
        text = re.sub(r"^# ([^\n{]*?)(?: *\{#\w+\})?\n\n*(?=([^\n])?)", lambda m: "%s %s\n\n%s" % (
            command, m[1], "\\details " if (m[2] or " ").isalnum() else ""), text)
        write("pages/%s.dox" % label, "".join("/// %s\n" % line for line in text.rstrip("\n").split("\n")))

    def write(path, text):
        path = os.path.join(out, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    public, more = public_headers()
    for path in public + more:
        write("include/cageform/" + path, doxygen_header(path))
    headers = set(public + more)

    names = files("examples/lessons", ".cpp")
    labels = [label_of("examples/lessons/" + name) for name in names]
    entries, table = [], []
    for n, name in enumerate(names):
        title, words, rest, page = lesson_page(name, labels[n - 1] if n else None,
                                               labels[n + 1] if n + 1 < len(names) else None)
        write_page(labels[n], page)
        entries.append((labels[n], title))
        more_words = "<br>" + rest[:1].upper() + rest[1:] if rest else ""
        table.append("%d. \\ref %s \"%s\"%s" % (n + 1, labels[n], words, more_words))
    write_page("lessons", LESSONS % "\n".join(table))

    rooms = []
    for room, words in ROOMS.items():
        readme = "include/cageform/%s/README.md" % room
        text = ""
        if os.path.exists(os.path.join(ROOT, readme)):
            text = relinked(read(readme), os.path.dirname(readme), headers)
            text = re.sub(r"^# [^\n]*\n", "", text)
        write_page("room_" + room, "\\defgroup room_%s %s\n\n%s\n\n%s\n" % (
            room, room, words[:1].upper() + words[1:] + ".", text + header_table(room, public)))
        rooms.append("| \\ref room_%s \"%s\" | %s |" % (room, room, words))
    write_page("rooms", ROOMS_PAGE % "\n".join(rooms))

    for label, path in [("gallery", "examples"), ("programs", "examples/programs"), ("sources", "examples/sources"), ("speed", "bench")]:
        write_page(label, relinked(read(path + "/README.md"), path, headers))
    for label, _, readme in LANGUAGES:
        text = relinked(read(readme), os.path.dirname(readme), headers)
        if label == "c":
            text += "\n\n<h2>The header</h2>\n\n```c\n%s```\n" % read("include/cageform/c/cageform.h")
        write_page(label, text)
    for path in ["CHANGELOG.md"] + [SITE + "/" + name for name in files(SITE, ".md")]:
        check_paths(path, read(path))
        text = relinked(read(path), os.path.dirname(path), headers).replace("@README_CODE@", readme_code())
        text = text.replace("@PLAY@", play()).replace("@TYPES@", type_table())
        write_page(label_of(path), text)
    write("layout.xml", layout(entries))
    print("%d public headers, %d of the machinery, %d lessons" % (len(public), len(more), len(names)))


KIND = r" (Class|Struct|Concept|Namespace|File|Union)( Template)? Reference"


def finished(name, text):
    """Edits a page of Doxygen: shortens titles, and links the project's name to the main page."""
    def title(found):
        return "<title>%s</title>" % ("cageform" if found[1] == "cageform" else found[1] + " · cageform")

    def heading(found):
        words = re.sub(r"&lt; (.*?) &gt;", r"&lt;\1&gt;", found[2])
        kind = (found[3] + (found[4] or "")).lower()
        return "%s%s <span class=\"kind\">%s</span>" % (found[1], words, kind)

    text = text.replace("<div id=\"projectname\">cageform",
                        "<div id=\"projectname\"><a href=\"index.html\">cageform</a>")
    text = re.sub(r"<title>cageform: (.*?)(?:%s)?</title>" % KIND, title, text)
    text = re.sub(r"(<div class=\"title\">)(?:cageform::)?(.*?)%s" % KIND, heading, text)
    text = text.replace("<h2 class=\"groupheader\">Detailed Description</h2>", "")
    text = re.sub(r"<li class=\"navelem\"><a class=\"el\" href=\"dir_\w+\.html\">(.*?)</a></li>",
                  r"<li class=\"navelem\">\1</li>", text)
    if re.match(r"[a-z]", name) and not re.match(r"(class|struct|group_|namespace|concept|\w+_8hpp)", name):
        text = re.sub(r"(<div class=\"textblock\">\s*)<p *>", r"\1<p class='lead'>", text, count=1)
    # In programs Doxygen links variables to any other variable with the same name.
    linked = r"<a class=\"code hl_(?:enumvalue|variable%s)\"[^>]*>(%s)</a>"
    text = re.sub(linked % ("|function", "out|points|figure|pose|value|size|[a-z]"), r"\1", text)
    return re.sub(linked % ("", r"[a-z_]\w*"), r"\1", text)


def finish(folder):
    """Edits all pages; deletes pages without links to them, and pages that repeat the members of a class."""
    for name in sorted(os.listdir(folder)):
        path = os.path.join(folder, name)
        if not name.endswith(".html"):
            continue
        with open(path, encoding="utf-8") as file:
            text = file.read()
        if (name.endswith("_8dox.html") or name.startswith("dir_") or
                "<p>This is the complete list of members for" in text):
            os.remove(path)
            continue
        with open(path, "w", encoding="utf-8") as file:
            file.write(finished(name, text))
    # The search does not list files that contain only pages.
    for name in os.listdir(os.path.join(folder, "search")):
        if name.endswith(".js"):
            path = os.path.join(folder, "search", name)
            with open(path, encoding="utf-8") as file:
                lines = [line for line in file if "_8dox.html" not in line]
            with open(path, "w", encoding="utf-8") as file:
                file.writelines(lines)
    # The window of search results is a separate page with a separate style sheet.
    with open(os.path.join(folder, "search", "search.css"), "a", encoding="utf-8") as file:
        file.write(read(SITE + "/style.css"))


if __name__ == "__main__":
    finish(sys.argv[2]) if sys.argv[1] == "--finish" else main(sys.argv[1])
