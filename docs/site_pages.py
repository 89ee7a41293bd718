"""What mkdocs.yml makes the site of: every page of the repository at its own place, so that links lead where they lead
in the repository, with the same anchors as tests/docs/check_links.py (those of the forges)."""

import pathlib
import sys

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE_FOLDERS = ('.', 'bench', 'configs', 'docs')
FILE_FOLDERS = ('docs', 'docs/images', 'examples/cpp')
FILE_ENDINGS = ('.png', '.jpg', '.json', '.cpp')

sys.path.insert(0, str(ROOT / 'tests/docs'))
sys.dont_write_bytecode = True  # the source folder stays as it is
import check_links  # noqa: E402


def on_config(config):
    config['mdx_configs'].setdefault('toc', {})['slugify'] = lambda heading, _: check_links.anchor(heading)
    return config


def on_files(files, config):
    """The repository's pages and what they show, in place of the folder that MkDocs looked into."""
    paths = [page for folder in PAGE_FOLDERS for page in sorted((ROOT / folder).glob('*.md'))]
    paths += [path for folder in FILE_FOLDERS for path in sorted((ROOT / folder).iterdir()) if path.suffix in FILE_ENDINGS]
    own = [File(str(path.relative_to(ROOT)), str(ROOT), config['site_dir'], config['use_directory_urls']) for path in paths]
    return Files(own + [file for file in files if not pathlib.Path(file.abs_src_path).is_relative_to(config['docs_dir'])])


def on_nav(nav, config, files):
    """A page that nobody can find from the menu is an error."""
    forgotten = {file.src_uri for file in files.documentation_pages()} - {page.file.src_uri for page in nav.pages}
    if forgotten:
        raise PluginError(f"not in mkdocs.yml's nav: {', '.join(sorted(forgotten))}")
    return nav
