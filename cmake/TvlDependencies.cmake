# Third-party libraries, all from the distribution. Their headers are SYSTEM (imported targets are).
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs video calib3d features2d)
find_package(TBB REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json 3 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nanoflann REQUIRED)

include(TvlBagLibraries)

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
