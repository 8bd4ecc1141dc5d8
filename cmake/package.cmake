# cpack -G DEB, after a build: the packages marquetry, with the program, libmarquetry-dev, with the libraries, and
# python3-marquetry, with the Python package. Installed by
#     apt install ./marquetry_*.deb ./libmarquetry-dev_*.deb ./python3-marquetry_*.deb
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME marquetry)
set(CPACK_PACKAGE_VENDOR "Marquetry")
set(CPACK_PACKAGE_CONTACT "The founders of Marquetry <maintainers@marquetry.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
if(TARGET marquetry_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME marquetry)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS
  "libegl1, libgl1-mesa-dri, fonts-dejavu-core, libopenblas0-openmp")  # the viewer finds the first three itself
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ffmpeg, man-db, zenity | kdialog")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "Smooths, sharpens, stitches and denoises textures on the surface of their model, over all seams of its \
charts; finds distances and optical flow; unwraps, remeshes and tracks. With a viewer.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmarquetry-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(depends libeigen3-dev libtbb-dev libfmt-dev libembree-dev libfreetype-dev nlohmann-json3-dev libpng-dev zlib1g-dev libzstd-dev
  libdraco-dev libmeshoptimizer-dev libpugixml-dev
  pkg-config)
if(MARQUETRY_CHOLMOD AND CHOLMOD_INCLUDE AND CHOLMOD_LIBRARY)
  list(APPEND depends libsuitesparse-dev)
endif()
list(APPEND depends "marquetry (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")  # its module for pictures
list(JOIN depends ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "Headers and static libraries of Marquetry, for CMake's find_package(marquetry) and pkg-config.")

if(TARGET marquetry_python)
  math(EXPR python3_next "${Python3_VERSION_MINOR} + 1")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-marquetry)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${python3_next}), python3-numpy, python3-scipy, marquetry (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pil, python3-tqdm")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
  "Marquetry for Python: every verb of the program as a function, and its spaces, matrices and equations.")

include(CPack)
