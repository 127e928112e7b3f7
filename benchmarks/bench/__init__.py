"""Helpers of the comparison scripts. Poses are arrays (n, 4, 4), T_world_lidar unless named otherwise."""
