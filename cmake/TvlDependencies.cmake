# Third-party libraries, all from the distribution. Their headers are SYSTEM (imported targets are).
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs video calib3d features2d)
find_package(TBB REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json 3 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nanoflann REQUIRED)

# Bags of ROS: databases and compressed chunks. LZ4 and Zstandard come with pkg-config files only,
# or with CMake files whose target names differ from version to version.
find_package(SQLite3 REQUIRED)
find_package(BZip2 REQUIRED)
foreach(name lz4 zstd)
  find_library(TVL_${name}_LIBRARY ${name} REQUIRED)
  find_path(TVL_${name}_INCLUDE_DIR ${name}.h REQUIRED)
  if(NOT TARGET tvl::${name})
    add_library(tvl::${name} UNKNOWN IMPORTED)
    set_target_properties(tvl::${name} PROPERTIES IMPORTED_LOCATION ${TVL_${name}_LIBRARY}
                          INTERFACE_INCLUDE_DIRECTORIES ${TVL_${name}_INCLUDE_DIR})
  endif()
endforeach()

# yaml-cpp before 0.8 exports a plain target name and no namespace.
if(NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()

# The simulator needs Embree 3 or 4; everything else builds without it.
find_package(embree 4 QUIET)
if(embree_FOUND)
  set(TVL_EMBREE_MAJOR 4)
else()
  find_package(embree 3 QUIET)
  set(TVL_EMBREE_MAJOR 3)
endif()
if(embree_FOUND)
  message(STATUS "Simulator: Embree ${TVL_EMBREE_MAJOR}")
else()
  message(STATUS "Simulator: not built (Embree not found)")
endif()

if(TVL_BUILD_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
