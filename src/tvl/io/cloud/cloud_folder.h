// Recordings that are a folder of scan files, as strangers have them.
//
// Scans: .bin (float32 records), .pcd, .ply or .las files in the folder itself or in one sub folder
// (velodyne, lidar, points, scans, clouds and the like, else the only one that holds some), in
// natural order of their names. Stamps: a text file beside them (times.txt, timestamps.txt, any
// .csv), else the names where they are times. Images: a sub folder of a usual name. calib.txt: in
// KITTI's odometry format. io/kitti/ has KITTI's other layouts: ask their LooksLike first.
#pragma once

#include <string>

#include "tvl/io/recording.h"

namespace tvl {

// Whether `path` is a folder in which OpenCloudFolder would find scans, or a single scan file by
// its extension. Looks at names only.
bool LooksLikeCloudFolder(const std::string& path);

// `path` may also be a single scan file. What was recognised is in the notes, what is doubtful in
// the warnings. Images are taken by their own stamps where scans have some of the same clock, else
// by name or number, else by position where there are as many. Reads the first scan and the first
// image. Throws InputError naming folder or file: nothing there, scans in several folders, scans
// none of which can be read, .bin files that are no points, LAZ.
Recording OpenCloudFolder(const std::string& path);

}  // namespace tvl
