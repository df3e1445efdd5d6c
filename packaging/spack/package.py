import os

from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Gracecg(CMakePackage):
    """Centre-of-gravity calibration of GRACE-type satellites: simulate, estimate, plan."""

    # Where gracecg has an address: homepage, url, and the sha256 of each version.
    # In a checkout: spack dev-build gracecg@0.2.0
    license("MIT AND CC-BY-4.0", checked_by="the gracecg authors")

    version("0.2.0")

    variant("shared", default=True, description="Build the shared libraries, not the static ones")
    variant("python", default=False, when="+shared", description="Install the Python package")

    depends_on("fortran", type="build")
    depends_on("cmake@3.20:", type="build")
    depends_on("lapack")
    depends_on("zlib-api", type="run")

    extends("python@3.9:", when="+python")
    depends_on("py-cffi@1.15:", type=("build", "run"), when="+python")
    depends_on("py-numpy@1.22:", type=("build", "run"), when="+python")

    conflicts("%gcc@:9")

    def cmake_args(self):
        return [self.define_from_variant("BUILD_SHARED_LIBS", "shared")]

    @run_after("install", when="+python")
    def install_python(self):
        """The package looks for headers and the library below its own folder."""
        folder = join_path(python_platlib, "gracecg")
        install_tree("python/gracecg", folder)
        mkdirp(join_path(folder, "include"), join_path(folder, "lib"))
        install("include/*.h", join_path(folder, "include"))
        library = find_libraries("libgracecg_level1", root=self.prefix, recursive=True)[0]
        symlink(library, join_path(folder, "lib", os.path.basename(library)))

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        Executable(self.prefix.bin.gracecg)("bound", "front-3")
