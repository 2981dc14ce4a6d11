// An executable with one node: ASAP_NODE is asap_node or cluster_tracker.
namespace asap_ros {
int ASAP_NODE(int argc, char** argv);
}
int main(int argc, char** argv) { return asap_ros::ASAP_NODE(argc, argv); }
