#include "package_node.hpp"

int main(int argc, char** argv) { return asap_ros::spin<asap_ros::PackageNode>(argc, argv); }
