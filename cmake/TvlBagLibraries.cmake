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
