"""Output files: all or nothing."""

import os

import pytest

from app.output import check_writable, write_files
from kernel.errors import OptionError


def test_files_arrive_whole_and_leave_nothing_beside(tmp_path):
    write_files({str(tmp_path / "a.bdf"): b"one", str(tmp_path / "b.html"): b"two"})
    assert (tmp_path / "a.bdf").read_bytes() == b"one"
    assert sorted(os.listdir(tmp_path)) == ["a.bdf", "b.html"]


def test_an_existing_file_keeps_its_content_when_another_of_the_group_cannot_be_written(tmp_path):
    (tmp_path / "a.bdf").write_bytes(b"old")
    with pytest.raises(OptionError, match="missing"):
        write_files({str(tmp_path / "a.bdf"): b"new", str(tmp_path / "missing" / "b.html"): b"two"})
    assert (tmp_path / "a.bdf").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bdf"]


def test_a_replaced_file_keeps_its_mode_and_a_new_one_follows_the_umask(tmp_path):
    old = tmp_path / "old"
    old.write_bytes(b"")
    old.chmod(0o640)
    before = os.umask(0o027)
    try:
        write_files({str(old): b"x", str(tmp_path / "new"): b"x"})
    finally:
        os.umask(before)
    assert old.stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640


def test_the_umask_is_left_alone_for_it_is_that_of_all_threads(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "umask", None)
    write_files({str(tmp_path / "new"): b"x"})
    assert (tmp_path / "new").read_bytes() == b"x"


def test_a_link_is_followed(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_files({str(tmp_path / "link"): b"x"})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"x"


def test_a_device_is_written_to_and_stays_a_device():
    write_files({"/dev/null": b"x"})
    assert not os.path.isfile("/dev/null")


@pytest.mark.parametrize("path, complaint", [("missing/a.bdf", "there is no folder"), (".", "is a folder")])
def test_an_unwritable_path_is_known_before_the_work(tmp_path, path, complaint):
    with pytest.raises(OptionError, match=complaint):
        check_writable(str(tmp_path / path))


def test_a_file_that_cannot_be_written_is_an_error_of_one_line():
    with pytest.raises(OptionError, match=r"^/proc/a.bdf: cannot be written"):
        write_files({"/proc/a.bdf": b"x"})
