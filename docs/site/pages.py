"""Copies the pages to where Sphinx reads them, and makes a page of each file of the repository that they link to."""

import fnmatch
import os
import pathlib
import re
import shutil
import subprocess

# A link or picture of Markdown: what is before the target, the target, its anchor.
LINK = re.compile(r"(\]\()([^)#\s]*)(#[^)\s]*)?(?=\))")
CODE = re.compile(r"(?ms)^( *)(```+|~~~+).*?^\1\2[`~]*[ ]*$|(?<!`)(`+)(?!`).*?(?<!`)\3(?!`)|<!--.*?-->")
LOADED = re.compile(r"(?m)^:load: (\S+)$")  # a program that a notebook runs
PICTURES = {".png", ".webp", ".svg", ".gif", ".jpg"}
LANGUAGES = {".json": "json", ".py": "python", ".cpp": "cpp", ".hpp": "cpp", ".sh": "sh", ".ts": "ts", ".yaml": "yaml",
             ".cff": "yaml", ".md": "markdown", ".mjs": "js", ".html": "html", ".txt": "text"}
HEAD = ["---", "orphan: true", "nosearch: true", "---", ""]  # neither in the side bar nor in the search
LARGEST_SHOWN = 60_000  # bytes; longer files are only kept for download
MOST_SHOWN = 40  # files of a folder that have pages of their own


def repository_files(root):
    """All files that git knows of or would add, as paths relative to the root."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            capture_output=True, check=True).stdout.decode()
    return sorted(pathlib.PurePosixPath(name) for name in set(listed.split("\0")) - {""} if (root / name).is_file())


def pages_of(files):
    """The pages of the site: those of the root, of slicer/ and of docs/, but for docs/site."""
    return [file for file in files if file.suffix == ".md" and
            (len(file.parts) == 1 or file.parts[0] == "slicer" or (file.parts[0] == "docs" and file.parts[1] != "site"))]


def outside_code(text, change):
    """The text with change() applied to all but code and comments."""
    done, end = [], 0
    for code in CODE.finditer(text):
        done += [change(text[end:code.start()]), code.group(0)]
        end = code.end()
    return "".join([*done, change(text[end:])])


def links_of(text):
    """(target, anchor) of each link and picture outside of code; the anchor without its #."""
    found = []
    outside_code(text, lambda part: found.extend((m[2], (m[3] or "")[1:]) for m in LINK.finditer(part)) or part)
    return found


class Pages:
    """Writes the sources of the site below an empty folder."""

    def __init__(self, root, folder):
        self.root, self.folder = root, folder
        self.files = repository_files(root)
        self.pages = set(pages_of(self.files))
        self.folders = {parent for file in self.files for parent in file.parents}
        self.shown = set()  # files and folders of the repository that have a page

    def matching(self, pattern):
        """The pages that a pattern of the front page names: /docs/notes/*."""
        return [page for page in self.pages if fnmatch.fnmatch(f"/{page.with_suffix('')}", pattern)]

    def add(self, name, text):
        """A page or another text."""
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def copy(self, source, name):
        """A file as it is."""
        target = self.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.root / source, target)

    def add_page(self, file):
        """A page of the repository, with links that lead to pages of the site."""
        text = (self.root / file).read_text()
        for program in LOADED.findall(text):
            program = pathlib.PurePosixPath(os.path.normpath(file.parent / program))
            self.copy(program, program)
        self.add(file, self.with_links(text, file.parent, file.parent))

    def with_links(self, text, read_from, written_to):
        """The text with its links rewritten. They are relative to one folder, and become relative to another."""
        def link(match):
            begin, target, anchor = match[1], match[2], match[3] or ""
            if "://" in target or target.startswith("mailto:") or not target:
                return match[0]
            file = pathlib.PurePosixPath(os.path.normpath(read_from / target))
            if file.suffix in PICTURES and file in self.files:
                self.copy(file, file)
            elif file in self.files or file in self.folders:
                if file not in self.pages:
                    file = self.page_of(file)
                    anchor = ""
            else:  # Sphinx says where
                return match[0]
            return f"{begin}{os.path.relpath(file, written_to)}{anchor}"
        return outside_code(text, lambda part: LINK.sub(link, part))

    def page_of(self, file):
        """The page that shows a file or folder of the repository; made where there is none yet."""
        page = pathlib.PurePosixPath("files") / f"{file}.md"
        if file not in self.shown:
            self.shown.add(file)
            self.add(page, self.shown_folder(file, page) if file in self.folders else self.shown_file(file, page))
        return page

    def shown_folder(self, folder, page):
        inside = [file for file in self.files if folder in file.parents]
        rows = [f"- [{file.relative_to(folder)}]({os.path.relpath(self.page_of(file), page.parent)})"
                if len(inside) <= MOST_SHOWN and file not in self.pages else f"- `{file.relative_to(folder)}`"
                for file in inside]
        return "\n".join([*HEAD, f"# {folder}/", "", "A folder of the repository.", "", *rows, ""])

    def shown_file(self, file, page):
        self.copy(file, page.with_suffix(""))
        head = [*HEAD, f"# {file}", "",
                f"A file of the repository: {{download}}`download <{file.name}>`.", ""]
        if file.suffix in PICTURES:
            return "\n".join([*head[:-2], f"![{file.name}]({file.name})", ""])
        if (self.root / file).stat().st_size > LARGEST_SHOWN or file.suffix == ".vtu":
            return "\n".join(head)
        language = LANGUAGES.get(file.suffix, "text")
        return "\n".join([*head, f"```{{literalinclude}} {file.name}", f":language: {language}", "```", ""])
