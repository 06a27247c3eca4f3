"""Usage: python3 examples/site/check_links.py FOLDER

Checks all links and pictures in the HTML files of a folder, and the addresses in the data of the search and
the menu. Prints the number of pages, their size and the broken links. Fails if a link is broken, leads
out of the folder, or refers to a missing anchor. Network addresses are only counted.
"""
import html.parser
import os
import re
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        for name in ("id", "name"):
            if attributes.get(name):
                self.anchors.add(attributes[name])
        for name in ("href", "src", "data"):
            if attributes.get(name):
                self.links.append(attributes[name])


def main(folder):
    pages, broken, outside, size = {}, [], set(), 0
    for base, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(base, name)
            size += os.path.getsize(path)
            if name.endswith(".html") and name != "cageform.html":  # the interactive page has no links
                with open(path, encoding="utf-8") as file:
                    pages[os.path.normpath(path)] = Page(file.read())
    links = [(path, link) for path, page in pages.items() for link in page.links]
    for base, _, names in os.walk(folder):
        for name in names:
            if name.endswith(".js") and (base.endswith("search") or name == "menudata.js"):
                path = os.path.join(base, name)
                with open(path, encoding="utf-8") as file:
                    text = file.read()
                found = re.findall(r"['\"]((?:\.\./)?\w+\.html(?:#\w+)?)['\"]", text)
                links += [(path, link) for link in found]
    for path, link in links:
        if re.match(r"(javascript|data):", link):
            continue
        if re.match(r"[a-z]+:|//", link):
            outside.add(link)
            continue
        target, _, anchor = link.partition("#")
        target = urllib.parse.unquote(target.split("?")[0])
        file = os.path.normpath(os.path.join(os.path.dirname(path), target) if target else path)
        if os.path.relpath(file, folder).startswith("..") or not os.path.isfile(file):
            broken.append("%s: %s" % (os.path.relpath(path, folder), link))
        elif anchor and file in pages and urllib.parse.unquote(anchor) not in pages[file].anchors:
            broken.append("%s: no place %s" % (os.path.relpath(path, folder), link))
    for line in sorted(set(broken)):
        print(line, file=sys.stderr)
    print("%d pages, %.1f MB, %d links, %d to the network, %d broken" % (
        len(pages), size / 1e6, len(links), len(outside), len(set(broken))))
    return 1 if broken or not pages else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
