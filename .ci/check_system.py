"""Report missing system packages before Blender fails on them. Needs only Python.

python .ci/check_system.py             print one line and exit with status 1 where a package is missing
python .ci/check_system.py --packages  print only the names of the missing packages, for a package manager
"""

import ctypes
import sys

# Libraries that the bpy wheel is linked against, and their packages in Debian and Ubuntu.
LIBRARIES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libX11.so.6": "libx11-6",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXrender.so.1": "libxrender1",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
}
DRIVER = "libgl1-mesa-dri"
SURFACELESS = 0x31DD  # EGL_PLATFORM_SURFACELESS_MESA


def loads(library: str) -> bool:
    """Return whether the dynamic linker finds a library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def draws() -> bool:
    """Return whether images can be rendered without a display."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetPlatformDisplay.restype = ctypes.c_void_p
    egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    display = egl.eglGetPlatformDisplay(SURFACELESS, None, None)
    return bool(display and egl.eglInitialize(display, None, None))


def missing() -> list[str]:
    """Return the names of the packages to install."""
    if sys.platform != "linux":
        return []
    packages = [package for library, package in LIBRARIES.items() if not loads(library)]
    if "libegl1" in packages or not draws():
        packages.append(DRIVER)
    return packages


def main() -> int:
    """Print what is missing and return the exit status."""
    packages = " ".join(missing())
    if "--packages" in sys.argv:
        print(packages)
        return 0
    if packages:
        print(f"Blender needs system libraries: run `sudo apt-get install {packages}`.", file=sys.stderr)
    return int(bool(packages))


if __name__ == "__main__":
    sys.exit(main())
