"""Files are written whole or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from elastocal.errors import InputError
from elastocal.io import require_writable, write_files
from support.files import contents


def fail_at(monkeypatch: pytest.MonkeyPatch, name: str, call: int) -> None:
    """Let the nth call of a method of Path fail as a full disk does."""
    calls, method = [0], getattr(Path, name)

    def failing(path: Path, *arguments: object, **options: object) -> object:
        calls[0] += 1
        if calls[0] == call:
            raise OSError(28, "No space left on device", str(path))
        return method(path, *arguments, **options)

    monkeypatch.setattr(Path, name, failing)


def test_files_are_written_into_a_folder_that_is_made(tmp_path: Path):
    write_files(tmp_path / "a" / "b", {"one.txt": "1 µm\n", "two.bin": b"\x00\xff"})
    assert contents(tmp_path) == {"a/b/one.txt": "1 µm\n".encode(), "a/b/two.bin": b"\x00\xff"}


def test_old_files_are_replaced_and_others_left_alone(tmp_path: Path):
    (tmp_path / "one.txt").write_text("old")
    (tmp_path / "other.txt").write_text("other")
    write_files(tmp_path, {"one.txt": "new"})
    assert contents(tmp_path) == {"one.txt": b"new", "other.txt": b"other"}


@pytest.mark.parametrize("umask", [0o022, 0o077])
def test_files_may_be_read_by_whom_the_user_lets_read(tmp_path: Path, umask: int):
    before = os.umask(umask)
    try:
        write_files(tmp_path, {"one.txt": "1"})
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "one.txt").stat().st_mode) == 0o666 & ~umask


@pytest.mark.parametrize(("method", "call"), [("chmod", 1), ("chmod", 2), ("replace", 1), ("replace", 2)])
def test_should_one_file_fail_none_is_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str, call: int):
    (tmp_path / "one.txt").write_text("old one")
    (tmp_path / "two.txt").write_text("old two")
    fail_at(monkeypatch, method, call)
    with pytest.raises(InputError, match="cannot be written to: no space left on device"):
        write_files(tmp_path, {"new.txt": "new", "one.txt": "new one", "two.txt": "new two"})
    assert contents(tmp_path) == {"one.txt": b"old one", "two.txt": b"old two"}


@pytest.mark.parametrize(("method", "call"), [("mkdir", 1), ("chmod", 1), ("replace", 1), ("replace", 2)])
def test_should_one_file_fail_a_new_folder_is_gone_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str, call: int
):
    fail_at(monkeypatch, method, call)
    with pytest.raises(InputError):
        write_files(tmp_path / "a" / "b", {"one.txt": "1", "two.txt": "2"})
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_changes_nothing_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def interrupted(_: Path, __: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "chmod", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files(tmp_path / "a", {"one.txt": "1"})
    assert list(tmp_path.iterdir()) == []


def test_an_input_is_never_overwritten_by_whatever_path_it_is_reached(tmp_path: Path):
    (tmp_path / "fit.csv").write_text("measured")
    (tmp_path / "link").symlink_to(tmp_path)
    for folder in (tmp_path, tmp_path / "link", tmp_path / "link" / ".." / tmp_path.name):
        with pytest.raises(InputError, match="is an input, which a result never overwrites"):
            write_files(folder, {"new.txt": "new", "fit.csv": "new"}, never=[tmp_path / "fit.csv"])
    assert contents(tmp_path) == {"fit.csv": b"measured"}


def test_all_that_is_in_the_way_is_told_at_once(tmp_path: Path):
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    with pytest.raises(InputError) as refused:
        require_writable(tmp_path, ["one", "two", "three"], [tmp_path / "three"])
    assert len(refused.value.faults) == 3
