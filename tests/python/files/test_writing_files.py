"""Files are written completely or not at all: order of system calls, links, permissions, names."""

import errno
import os
import socket
import stat
import subprocess
import sys
import textwrap
from pathlib import Path

import fullbody
import pytest
from fullbody.base.atomic import check_target, replacing
from support import forbid, refused


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.case1()
    return system.integrate(state, 10.0, output=2.0)


def simulation():
    return fullbody.Simulation(*fullbody.systems.case1())


def autosaved(_, path):
    simulation().integrate(1.0, autosave=(path, 0.0))


WRITERS = {
    "run.nc": lambda run, path: run.save(path),
    "run.sim": lambda run, path: simulation().save(path),
    "auto.sim": autosaved,
    "film.gif": lambda run, path: run.animate(path, seconds=0.1, fps=10, size=(1, 1), dpi=20),
    "view.html": lambda run, path: run.view().save_html(path),
}
every_writer = pytest.mark.parametrize("name", WRITERS)
quiet = pytest.mark.filterwarnings("ignore:.*turns between two")


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


# Whole or not at all


def test_a_full_disk_is_an_error_and_not_the_end_of_the_session(tmp_path):
    # The process may write no more than 30 kB to a file: HDF5 itself would end it by a segmentation fault.
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")
    script = f"""
        import resource, signal
        import fullbody
        system, state = fullbody.systems.case1()
        run = system.integrate(state, 10.0, output=0.02)
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (30000, resource.RLIM_INFINITY))
        try:
            run.save({str(path)!r})
        except OSError as error:
            print(error.filename, len(run))
    """
    ended = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip()) == (0, f"{path} 501"), ended.stderr
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("kind", [KeyboardInterrupt, ValueError, OSError])
def test_an_error_while_writing_leaves_the_old_file(kind, tmp_path):
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")

    def write():
        with replacing(path) as temporary:
            temporary.write_bytes(b"half")
            raise kind

    with pytest.raises(kind):
        write()
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


# Order of the system calls


def record_calls(monkeypatch, *, fail=None):
    """The calls that flush and rename, in order: (what, path, size)."""
    calls = []
    opened = {}
    originals = {name: getattr(os, name) for name in ("open", "fsync", "replace")}

    def open_(path, *args, **options):
        descriptor = originals["open"](path, *args, **options)
        opened[descriptor] = Path(path)
        return descriptor

    def fsync(descriptor):
        path = opened[descriptor]
        calls.append(("flush", path, None if path.is_dir() else path.stat().st_size))
        if fail is not None and path.is_dir() == (fail == "folder"):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return originals["fsync"](descriptor)

    def replace(source, target):
        calls.append(("replace", Path(source), Path(target)))
        return originals["replace"](source, target)

    for name, function in (("open", open_), ("fsync", fsync), ("replace", replace)):
        monkeypatch.setattr(os, name, function)
    return calls


@every_writer
@quiet
def test_a_file_is_flushed_before_it_replaces_and_its_folder_afterwards(name, run, tmp_path, monkeypatch):
    calls = record_calls(monkeypatch)
    path = tmp_path / name
    WRITERS[name](run, path)
    first, renamed, last = calls[-3:]
    assert renamed == ("replace", first[1], path)
    assert first == ("flush", renamed[1], path.stat().st_size)
    assert last == ("flush", tmp_path, None)
    assert len(calls) % 3 == 0


def test_a_disk_that_fails_leaves_the_old_file(run, tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")
    record_calls(monkeypatch, fail="file")
    with pytest.raises(OSError, match="Input/output error") as caught:
        run.save(path)
    assert caught.value.filename == str(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_fails_at_the_folder_is_an_error(run, tmp_path, monkeypatch):
    record_calls(monkeypatch, fail="folder")
    with pytest.raises(OSError, match="Input/output error"):
        run.save(tmp_path / "run.nc")


def test_files_are_written_where_folders_cannot_be_flushed(run, tmp_path, monkeypatch):
    original = os.fsync

    def fsync(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))
        original(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc") == run


# Links


@every_writer
@quiet
def test_a_link_stays_and_its_target_is_replaced(name, run, tmp_path):
    for folder in ("links", "data"):
        (tmp_path / folder).mkdir()
    target, link, chain = tmp_path / "data" / f"real-{name}", tmp_path / "links" / name, tmp_path / "links" / f"a{name}"
    target.write_bytes(b"old")
    link.symlink_to(Path("..", "data", target.name))
    chain.symlink_to(link)
    WRITERS[name](run, chain)
    assert chain.is_symlink()
    assert link.is_symlink()
    assert not target.is_symlink()
    assert len(target.read_bytes()) > 100
    assert link.read_bytes() == target.read_bytes()
    assert [path.name for path in (tmp_path / "data").iterdir()] == [target.name]


def test_a_link_to_nothing_makes_its_target(run, tmp_path):
    (tmp_path / "run.nc").symlink_to("later.nc")
    run.save(tmp_path / "run.nc")
    assert (tmp_path / "run.nc").is_symlink()
    assert fullbody.load(tmp_path / "later.nc") == run
    (tmp_path / "lost.nc").symlink_to("nowhere/run.nc")
    with pytest.raises(FileNotFoundError, match=r"no folder .*nowhere to write run\.nc in"):
        run.save(tmp_path / "lost.nc")


def test_links_in_a_circle_are_refused(run, tmp_path):
    (tmp_path / "a.nc").symlink_to("b.nc")
    (tmp_path / "b.nc").symlink_to("a.nc")
    with pytest.raises(OSError, match=r"a\.nc") as caught:
        run.save(tmp_path / "a.nc")
    assert caught.value.errno == errno.ELOOP


def test_other_hard_links_keep_the_old_content(run, tmp_path):
    (tmp_path / "old.nc").write_bytes(b"old")
    os.link(tmp_path / "old.nc", tmp_path / "run.nc")
    run.save(tmp_path / "run.nc")
    assert (tmp_path / "old.nc").read_bytes() == b"old"
    assert fullbody.load(tmp_path / "run.nc") == run


# Permissions


@pytest.mark.parametrize(("name", "umask"), [*((name, 0o077) for name in WRITERS), ("run.sim", 0o022)])
@quiet
def test_a_new_file_has_what_the_umask_leaves_and_later_keeps_its_permissions(name, umask, run, tmp_path):
    path, previous = tmp_path / name, os.umask(umask)
    try:
        WRITERS[name](run, path)
    finally:
        os.umask(previous)
    assert mode(path) == 0o666 & ~umask
    path.write_bytes(b"old")
    path.chmod(0o755 if umask == 0o022 else 0o640)
    WRITERS[name](run, path)
    assert len(path.read_bytes()) > 100
    assert mode(path) == (0o755 if umask == 0o022 else 0o640)


def test_what_replaces_a_private_file_is_private_from_the_first(tmp_path):
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")
    path.chmod(0o600)
    with replacing(path) as temporary:
        assert mode(temporary) == 0o600
        temporary.write_bytes(b"new")
        assert mode(temporary) == 0o600
    assert (path.read_bytes(), mode(path)) == (b"new", 0o600)


# Names


@pytest.mark.parametrize(
    "name",
    ["x" * 252, "€" * 84, "x." + "y" * 250, ".nc", "...nc", " .nc", "-", "a\nb"],
    ids=lambda name: repr(name)[:9],
)
def test_any_name_of_up_to_255_bytes_is_written(name, run, tmp_path):
    name = name if "." in name else f"{name}.nc"
    path = tmp_path / name
    simulation().save(path)
    assert fullbody.Simulation.load(path) == simulation()
    if path.suffix == ".nc":
        run.save(path)
        assert fullbody.load(path) == run
    assert [entry.name for entry in tmp_path.iterdir()] == [name]


def test_a_name_too_long_for_the_system_is_an_error(run, tmp_path):
    path = tmp_path / ("x" * 253 + ".nc")
    with pytest.raises(OSError, match="File name too long") as caught:
        run.save(path)
    assert caught.value.filename == str(path)


# Places that cannot be written


@every_writer
@quiet
def test_a_path_that_cannot_be_written_is_named_as_in_the_call(name, run, tmp_path, monkeypatch):
    path = tmp_path / name
    path.mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        WRITERS[name](run, path)
    assert str(caught.value) == f"[Errno 21] Is a directory: '{path}'"
    path.rmdir()
    forbid(monkeypatch)
    with pytest.raises(PermissionError) as caught:
        WRITERS[name](run, path)
    assert str(caught.value) == f"[Errno 13] Permission denied: '{path}'"
    assert list(tmp_path.iterdir()) == []


@every_writer
@quiet
def test_a_write_protected_file_is_not_replaced(name, run, tmp_path, monkeypatch):
    path = tmp_path / name
    path.write_bytes(b"old")
    path.chmod(0o444)
    # The tests may run as a user whom the system lets write it.
    monkeypatch.setattr(os, "access", lambda asked, how: (Path(asked), how) != (path, os.W_OK))
    with pytest.raises(PermissionError) as caught:
        WRITERS[name](run, path)
    assert str(caught.value) == f"[Errno 13] Permission denied: '{path}'"
    assert (path.read_bytes(), mode(path)) == (b"old", 0o444)


@every_writer
@quiet
def test_devices_and_the_like_are_not_replaced(name, run, tmp_path):
    pipe = tmp_path / name
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="Not a regular file") as caught:
        WRITERS[name](run, pipe)
    assert caught.value.filename == str(pipe)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    (tmp_path / f"link-{name}").symlink_to(pipe)
    with pytest.raises(OSError, match="Not a regular file"):
        WRITERS[name](run, tmp_path / f"link-{name}")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([f"link-{name}", name])


def test_a_socket_is_not_replaced(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket")
        with pytest.raises(OSError, match="Not a regular file"):
            simulation().save("socket")
        assert stat.S_ISSOCK(os.stat("socket").st_mode)


def test_standard_output_is_not_replaced(tmp_path):
    script = """
        import fullbody
        for name in ("/dev/stdout", "link"):
            try:
                fullbody.Simulation(*fullbody.systems.case1()).save(name)
            except OSError as error:
                print(error)
    """
    (tmp_path / "link").symlink_to("/dev/stdout")
    with (tmp_path / "printed").open("w") as printed:
        subprocess.run([sys.executable, "-c", textwrap.dedent(script)], stdout=printed, cwd=tmp_path, check=True)
    lines = (tmp_path / "printed").read_text().splitlines()
    assert [line.partition("]")[2] for line in lines] == [
        f" Not a regular file, which alone can be replaced: '{name}'" for name in ("/dev/stdout", "link")
    ]


def test_devices_are_not_read():
    for read in (fullbody.Simulation.load, fullbody.read_toml, fullbody.read_sians, fullbody.read_gubas):
        refused("/dev/zero is a device; expected a file", lambda read=read: read("/dev/zero"))
    refused("the file is not a NetCDF file", lambda: fullbody.load("/dev/zero"))


def test_a_folder_that_does_not_exist_is_named(run, tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no folder .*nowhere"):
        run.save(tmp_path / "nowhere" / "run.nc")
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"run\.nc|no folder"):
        run.save(tmp_path / "file" / "run.nc")


def test_a_folder_that_vanishes_while_the_file_is_written_is_named(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()

    def write():
        with replacing(folder / "run.nc") as temporary:
            temporary.unlink()
            folder.rmdir()
            temporary.write_bytes(b"new")

    with pytest.raises(FileNotFoundError) as caught:
        write()
    assert str(caught.value) == f"[Errno 2] No such file or directory: '{folder / 'run.nc'}'"


@pytest.mark.parametrize(
    "error",
    [
        lambda path: PermissionError(13, "Permission denied", str(path)),
        lambda path: OSError(f"unable to create file (name = '{path}')"),
        lambda path: OSError(28, "No space left on device"),
    ],
    ids=["python", "unnumbered", "nameless"],
)
def test_errors_while_writing_name_the_wanted_path(error, tmp_path):
    path = tmp_path / "run.nc"
    with pytest.raises(OSError, match=r"run\.nc") as caught, replacing(path) as temporary:
        raise error(temporary)
    assert str(path) in str(caught.value)
    assert temporary.name not in str(caught.value)
    assert "HDF5" not in str(caught.value)
    if "Permission" in str(error(path)):
        assert type(caught.value) is PermissionError
    # Errors about other files stay as they are.
    other = FileNotFoundError(2, "No such file or directory", "ffmpeg")
    with pytest.raises(FileNotFoundError) as caught, replacing(path):
        raise other
    assert caught.value is other


def test_a_check_of_a_path_changes_nothing(tmp_path):
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")
    previous = path.stat()
    check_target(path)
    check_target(tmp_path / "new.nc")
    assert path.stat() == previous
    assert list(tmp_path.iterdir()) == [path]
