"""A folder of trained models as one file, to carry weights to another machine: a plain zip with a checksum of every file.

Weights differ in their last bits between processors, so whoever needs those of another machine takes them along. Only JSON
and safetensors are packed or unpacked, so nothing in a bundle can run.
"""

import hashlib
import zipfile
from pathlib import Path, PurePosixPath
from typing import Any

from drivegen.core import safe_json
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.store.files import as_json, whole
from drivegen.store.folders import whole_folder

MANIFEST = "manifest.json"
ALLOWED = (".json", ".safetensors")
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the zip format's first moment: equal models give equal bytes


def pack(models: Path, bundle: Path) -> list[str]:
    """Write all models below the folder `models` into the file `bundle`; returns their names.

    Raises MissingTool where there is none, UnusableInput where a file is neither JSON nor safetensors, or its name no text.
    """
    files = {path.relative_to(models).as_posix(): path for path in sorted(models.rglob("*")) if path.is_file()}
    if not files:
        raise MissingTool(f"{models} holds no trained models: `make run` trains them, in the project's folder: change into it")
    if strange := [name for name in files if not name.endswith(ALLOWED)]:
        raise UnusableInput(f"{models / strange[0]} is no model (JSON or safetensors): remove it first")
    if unspeakable := [name for name in files if not name.isprintable()]:  # bytes that are no text, among others
        raise UnusableInput(f"{models}: {unspeakable[0]!a} is no name that another machine could write: rename it first")
    digests = {name: _sha256(path.read_bytes()) for name, path in files.items()}
    with whole(bundle) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        archive.writestr(zipfile.ZipInfo(MANIFEST, _EPOCH), as_json({"sha256": digests}))
        for name, path in files.items():
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), path.read_bytes())
    return list(files)


def unpack(bundle: Path, models: Path) -> list[str]:
    """Write the models of the file `bundle` into the new folder `models`, whole or not at all; returns their names.

    Raises UnusableInput where the file is no bundle, was cut off or changed, or where the folder is not empty.
    """
    if not bundle.is_file():
        raise UnusableInput(f"{bundle} is no file: name one that `drivegen weights save` wrote")
    try:
        with zipfile.ZipFile(bundle) as archive:
            digests = _manifest(archive, bundle)
            with whole_folder(models) as folder:
                for name, digest in digests.items():
                    content = archive.read(name)
                    if _sha256(content) != digest:
                        raise UnusableInput(f"{bundle}: {name} is not what was packed: copy the file again")
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
                    (folder / name).write_bytes(content)
    except (zipfile.BadZipFile, NotImplementedError, KeyError, EOFError, UnicodeError) as error:
        raise UnusableInput(f"{bundle} is no file of `drivegen weights save`, or was cut off ({error})") from None
    return list(digests)


def _manifest(archive: zipfile.ZipFile, bundle: Path) -> dict[str, str]:
    """Names and SHA-256 of what a bundle holds; raises UnusableInput for names that would lie elsewhere.

    `pack` neither compresses nor encrypts: whatever is, is not ours, and could unpack to anything.
    """
    if any(entry.compress_type != zipfile.ZIP_STORED or entry.flag_bits & 1 for entry in archive.infolist()):
        raise UnusableInput(f"{bundle} is compressed or encrypted: it is no file of `drivegen weights save`")
    entries = archive.infolist()
    if sum(entry.file_size for entry in entries) > bundle.stat().st_size or any(entry.header_offset < 0 for entry in entries):
        raise UnusableInput(f"{bundle} has entries over one another or outside: it is no file of `drivegen weights save`")
    try:
        digests: dict[str, Any] = dict(safe_json.parse(archive.read(MANIFEST), f"{bundle}: {MANIFEST}")["sha256"])
        names = [PurePosixPath(name) for name in digests]
    except (ValueError, TypeError, KeyError):
        raise UnusableInput(f"{bundle} has no list of models ({MANIFEST}): `drivegen weights save` writes one") from None
    if any(name.is_absolute() or ".." in name.parts or name.suffix not in ALLOWED for name in names):
        raise UnusableInput(f"{bundle} names a file that is no model of ours")
    return digests


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
