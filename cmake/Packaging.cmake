# What `cmake --install` puts where, and the Debian package that cpack makes of it (./package does both).
# The programs find their data in share/openhumanbrdf beside their bin folder (dataset/model/data_files.h).
set(data share/openhumanbrdf)
set(not_python PATTERN "__pycache__" EXCLUDE PATTERN "*.pyc" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/assets ${PROJECT_SOURCE_DIR}/blender_addon DESTINATION ${data}
        ${not_python} PATTERN "*.sh" EXCLUDE)
file(GLOB scripts ${PROJECT_SOURCE_DIR}/assets/*.sh)
install(PROGRAMS ${scripts} DESTINATION ${data}/assets)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/doc/openhumanbrdf)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/CHANGELOG.md
              ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md
              ${PROJECT_SOURCE_DIR}/CITATION.cff ${PROJECT_SOURCE_DIR}/cmake/copyright
        DESTINATION share/doc/openhumanbrdf)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME openhumanbrdf)
set(CPACK_PACKAGE_VENDOR "The OpenHumanBRDF developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "labels, bakes, renders and learns the materials of scanned humans")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"openhumanbrdf labels the hair, skin, fabric and leather of a scanned human,
bakes six material maps, renders relit, pixel-exact views and compares them
with Blender Cycles by a statistical test. humanmaterial trains networks on
such views and estimates the maps from one picture; small weights come along.
.
The programs need a processor of level ${OHB_ARCH}.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The OpenHumanBRDF developers <maintainers@openhumanbrdf.invalid>")
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# One package: what libtorch adds (OpenImageIO brings FFmpeg and OpenCV anyway) is less than Blender, which the
# commands that compare and relight need and the others do not.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "blender, gnuplot-nox, python3-numpy")
if(OHB_WITH_LEARNER)
  # With the reference BLAS, which satisfies libtorch, networks are some 50 times slower.
  set(CPACK_DEBIAN_PACKAGE_DEPENDS "libopenblas0-openmp | libopenblas0")
endif()
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "openimageio-tools")
include(CPack)
