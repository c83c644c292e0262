"""Siconos and FCLIB from Debian's packages, unpacked without being installed.

C programs are compiled against them by `compile_program`. They need apt-get, dpkg-deb and cc; where
something is missing, the functions return the reason.
"""

import shutil
import subprocess
from pathlib import Path

# These are the packages that libsiconos-numerics and libfclib need to run, and their headers.
PACKAGES = (
    "libsiconos-numerics7 libsiconos-numerics-dev libopenblas0-pthread liblapacke libtmglib3 "
    "libmumps-seq-5.5 libscotch-7.0 libmetis5 libcxsparse3 libldl2 libsuitesparseconfig5 "
    "libgfortran5 libquadmath0 libfclib0 libfclib-dev libhdf5-103-1 libhdf5-hl-100 libaec0 libsz2"
).split()


def unpack(root: Path) -> str:
    """Unpacks the packages below a folder, if they are not there; returns why not, or nothing."""
    missing = [tool for tool in ("apt-get", "dpkg-deb", "cc") if not shutil.which(tool)]
    if missing:
        return f"there is no {' and no '.join(missing)}"
    if all(list(root.glob(f"usr/lib/*/lib{name}.so")) for name in ("siconos_numerics", "fclib")):
        return ""
    shutil.rmtree(root, ignore_errors=True)
    root.mkdir(parents=True)
    loaded = subprocess.run(
        ["apt-get", "download", *PACKAGES], cwd=root, capture_output=True, text=True
    )
    if loaded.returncode:
        lines = [line for line in loaded.stderr.splitlines() if line.startswith("E:")]
        return (
            f"`apt-get download`: {(lines or ['it failed'])[0]} (`apt-get update` may help; the "
            "packages are those of Debian 12)"
        )
    for package in sorted(root.glob("*.deb")):
        subprocess.run(["dpkg-deb", "-x", package, root], check=True)
        package.unlink()
    return ""


def search_path(root: Path) -> str:
    """Returns the LD_LIBRARY_PATH of programs that were compiled against the packages."""
    libraries = next(root.glob("usr/lib/*/libsiconos_numerics.so")).parent
    return f"{libraries / 'openblas-pthread'}:{libraries}"


def compile_program(root: Path, source: Path, program: Path, libraries: list) -> str:
    """Compiles a C program if it is older than its source; returns why not, or nothing."""
    if program.exists() and program.stat().st_mtime >= source.stat().st_mtime:
        return ""
    headers, path = root / "usr/include", search_path(root)
    command = ["cc", "-O2", "-w", f"-I{headers}", f"-I{headers / 'siconos'}"]
    command += [f"-I{headers / 'siconos/numerics'}", f"-L{path.split(':')[1]}"]
    command += [f"-Wl,-rpath-link,{path}", source, "-o", program]
    command += [f"-l{name}" for name in (*libraries, "siconos_numerics", "siconos_externals", "m")]
    made = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    return "" if made.returncode == 0 else f"cc: {made.stderr.strip().splitlines()[-1]}"
