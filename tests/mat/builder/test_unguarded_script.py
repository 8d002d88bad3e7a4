"""A script builds without a main guard, and without modules that the machine lacks."""

import subprocess
import sys


def test_a_script_without_a_main_guard_runs_once(tmp_path, tiny_job):
    bands = "bands:\n  - wavelength_um: [10.0, 10.2]\n"
    assert bands in tiny_job()
    (tmp_path / "job.yaml").write_text(tiny_job().replace(bands, "bands: []\n"), encoding="utf-8")
    script = tmp_path / "script.py"
    script.write_text("import skyshine.mat\nprint(skyshine.mat.build('job.yaml', jobs=1))\n", encoding="utf-8")
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 1 and "1 file" in done.stdout


def test_memory_is_unknown_where_the_system_does_not_say(monkeypatch):
    from skyshine.schemas.process_memory import peak_memory

    assert peak_memory() > 1e7
    monkeypatch.setitem(sys.modules, "resource", None)
    assert peak_memory() is None


def test_commands_start_without_posix_modules(tmp_path, tiny_job):
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    code = (
        "import sys\n"
        "for name in ('resource', 'fcntl', 'pwd', 'grp', 'termios', 'tty', 'pty'):\n"
        "    sys.modules[name] = None\n"
        "from skyshine.mat.cli import main\n"
        "main(['check', 'job.yaml'])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "files: 1 atmq, 1 htt, 1 band" in done.stdout
