#include "cluster_tracker_node.hpp"

int main(int argc, char** argv) { return asap_ros::spin<asap_ros::ClusterTrackerNode>(argc, argv); }
