#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "sensing/robots.hpp"
#include "stiction/sensing/scenario.hpp"
#include "stiction/sensing/series_columns.hpp"
#include "stiction/world/read.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::sensing::test {
namespace {

namespace fs = std::filesystem;
using stiction::test::folder_of_the_process;
using stiction::test::message_of;
using stiction::test::TemporaryFolder;

std::string chain(const std::vector<std::string>& joints) {
  std::string out = "<robot name='r'><link name='l0'/>";
  for (std::size_t i = 0; i < joints.size(); ++i)
    out += "<link name='l" + std::to_string(i + 1) +
           "'><collision><geometry><sphere radius='0.1'/></geometry></collision></link><joint name='" + joints[i] +
           "' type='revolute'><parent link='l" + std::to_string(i) + "'/><child link='l" + std::to_string(i + 1) +
           "'/><origin xyz='0 0 0.5'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' effort='9' velocity='1'/></joint>";
  return out + "</robot>";
}

/// Shoulder, elbow and wrist.
std::shared_ptr<const world::Model> arm() { return make_robot(chain({"shoulder", "elbow", "wrist"})); }

std::shared_ptr<const world::Model> two_arms() {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "r.urdf") << chain({"elbow"});
  return world::Model::make(
      world::parse_scene("robots: [{name: left, urdf: r.urdf, base: {position: [0, 1, 0]}}, {name: right, urdf: r.urdf}]", folder.path()));
}

fs::path write(const std::string& text) {
  static int number = 0;
  fs::path file = folder_of_the_process() / ("series" + std::to_string(number++) + ".csv");
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

Series read(const std::string& text, const world::Model& model = *arm()) { return load_series(write(text), model); }
std::string refusal(const std::string& text, const world::Model& model = *arm()) {
  return message_of([&] { (void)read(text, model); });
}

const Eigen::Vector3d kPositions(0.1, 0.2, 0.3), kTorques(1, 2, 3);

void expect_columns_of_the_arm(const std::string& text) {
  const Series series = read(text);
  ASSERT_EQ(series.times, std::vector{0.5}) << text;
  EXPECT_EQ(series.q, kPositions) << text;
  EXPECT_EQ(series.tau, kTorques) << text;
}

TEST(Series, ColumnsAreTakenByTheirNames_InAnyOrder) {
  for (const char* text : {
           "t,q_shoulder,q_elbow,q_wrist,tau_shoulder,tau_elbow,tau_wrist\n0.5,0.1,0.2,0.3,1,2,3\n",
           "tau_wrist,q_elbow,tau_elbow,t,q_wrist,q_shoulder,tau_shoulder\n3,0.2,2,0.5,0.3,0.1,1\n",
           "__time,/joint_states/elbow/effort,/joint_states/elbow/position,/joint_states/shoulder/effort,/joint_states/shoulder/position,"
           "/joint_states/wrist/effort,/joint_states/wrist/position\n0.5,2,0.2,1,0.1,3,0.3\n",
           "Time [s],q_robot/elbow [rad],q_robot/wrist [rad],q_robot/shoulder [rad],tau_ext_elbow [Nm],tau_ext_wrist [Nm],tau_ext_shoulder "
           "[Nm]\n0.5,0.2,0.3,0.1,2,3,1\n",
           "\"time\",\"position.elbow\",\"position.shoulder\",\"position.wrist\",\"effort.elbow\",\"effort.shoulder\",\"effort.wrist\"\r\n"
           "0.5,0.2,0.1,0.3,2,1,3\r\n",
           "\xEF\xBB\xBFt,q3,q2,q1,tau1,tau2,tau3\n0.5,0.3,0.2,0.1,1,2,3\n",
           "t,q[2],q[1],q[0],tau[0],tau[1],tau[2]\n0.5,0.3,0.2,0.1,1,2,3\n",
           "t;q_wrist;q_elbow;q_shoulder;tau_shoulder;tau_elbow;tau_wrist\n0,5;0,3;+2,0e-1;0.1;1;2;3\n",
           "t\tq_wrist\tq_elbow\tq_shoulder\ttau_shoulder\ttau_elbow\ttau_wrist\n0.5\t0.3\t0.2\t0.1\t1\t2\t3\n",
           "# made by a recorder\n# t,q_wrist,q_elbow,q_shoulder,tau_shoulder,tau_elbow,tau_wrist\n0.5,0.3,0.2,0.1,1,2,3\n",
       })
    expect_columns_of_the_arm(text);
}

TEST(Series, TableWithoutNames_IsTakenByPosition_FromItsFirstLine) {
  expect_columns_of_the_arm("0.5,0.1,0.2,0.3,1,2,3\n");
  expect_columns_of_the_arm("0,5;0,1;0,2;0,3;1;2;3\n");
  expect_columns_of_the_arm("# made by a recorder\n\n+0.5, 0.1, 0.2, 0.3, +1, 2, 3\n");
  const Series two = read("0,1,1,1,1,1,1\n1,2,2,2,2,2,2\n");
  EXPECT_EQ(two.times, (std::vector{0.0, 1.0}));
  EXPECT_EQ(two.q.col(0), Eigen::Vector3d::Ones());
}

TEST(Series, FirstLineThatIsNoLineOfNames_IsRefusedAndNotLeftOut) {
  EXPECT_NE(refusal("0,nan,0,0,0,0,0\n1,0,0,0,0,0,0\n")
                .find(":1: series: got '0,nan,0,0,0,0,0', with 'nan' in column 2, expected a finite number"),
            std::string::npos);
  EXPECT_NE(refusal("0,,0,0,0,0,0\n1,0,0,0,0,0,0\n")
                .find(":1: series: got '0,,0,0,0,0,0', expected a name for every column, or 7 finite numbers"),
            std::string::npos);
  EXPECT_NE(refusal("0,0,0\n").find(":1: series: got 3 numbers, expected 7 finite numbers: a time, 3 joint positions, 3 torques"),
            std::string::npos);
}

TEST(Series, OtherColumns_AreLeftOutAndSaid) {
  const Series series = read(
      "frame,/joint_states/gripper/"
      "position,t,q_cmd_elbow,q_wrist,q_elbow,q_shoulder,dq_elbow,tau_shoulder,tau_elbow,tau_wrist,effort_elbow\n"
      "base,nan,0.5,,0.3,0.2,0.1,,1,2,3,8\n");
  EXPECT_EQ(series.q, kPositions);
  EXPECT_EQ(series.tau, kTorques);
  ASSERT_EQ(series.notes.size(), 1u);
  EXPECT_NE(series.notes[0].find(
                "columns that are not read: 'frame', '/joint_states/gripper/position', 'q_cmd_elbow', 'dq_elbow', 'effort_elbow'"),
            std::string::npos)
      << series.notes[0];
}

TEST(Series, Efforts_AreTakenWithANote) {
  const Series series = read("t,q1,q2,q3,effort_shoulder,effort_elbow,effort_wrist\n0.5,0.1,0.2,0.3,1,2,3\n");
  EXPECT_EQ(series.tau, kTorques);
  ASSERT_EQ(series.notes.size(), 1u);
  EXPECT_NE(series.notes[0].find("efforts are taken for the external torques"), std::string::npos);
}

TEST(Series, NamesOfMakers_AreKnown) {
  for (const char* head : {"timestamp,actual_q_0,actual_q_1,actual_q_2,tau_ext0,tau_ext1,tau_ext2",
                           "time,q[0],q[1],q[2],tau_ext_hat_filtered[0],tau_ext_hat_filtered[1],tau_ext_hat_filtered[2]",
                           "t,shoulder/position,elbow/position,wrist/position,shoulder/torque,elbow/torque,wrist/torque"}) {
    const Series series = read(std::string(head) + "\n0.5,0.1,0.2,0.3,1,2,3\n");
    EXPECT_EQ(series.q, kPositions) << head;
    EXPECT_EQ(series.tau, kTorques) << head;
  }
  const Series franka = read("t,q0,q1,q2,tau_ext_hat_filtered0,tau_ext_hat_filtered1,tau_ext_hat_filtered2\n0.5,0.1,0.2,0.3,1,2,3\n");
  ASSERT_EQ(franka.notes.size(), 1u);
  EXPECT_NE(franka.notes[0].find("what the robot does to its surroundings"), std::string::npos);
  const Series motors = read("t,q0,q1,q2,tau_J0,tau_J1,tau_J2\n0.5,0.1,0.2,0.3,1,2,3\n");
  EXPECT_NE(motors.notes.at(0).find("gravity"), std::string::npos);
}

TEST(Series, JointsWithoutASensor_NeedNoColumn) {
  const auto model = arm();
  const Series series = load_series(write("t,q0,q1,tau_ext0,tau_ext1\n0.5,0.1,0.3,1,3\n"), *model, {1});
  EXPECT_EQ(series.q, Eigen::Vector3d(0.1, 0, 0.3));
  EXPECT_EQ(series.tau, Eigen::Vector3d(1, 0, 3));
  EXPECT_EQ(load_series(write("0.5,0.1,0.3,1,3\n"), *model, {1}).tau, Eigen::Vector3d(1, 0, 3));
  EXPECT_NE(refusal("t,q0,q1,tau_ext0,tau_ext1\n0.5,0.1,0.3,1,3\n").find("a joint without a torque sensor is named in sensing.unmeasured"),
            std::string::npos);
}

TEST(Series, LinesThatLackANumber_AreNoMoments) {
  const Series series =
      read("t,q0,q1,q2,tau0,tau1,tau2,x\n0,0.1,0.2,0.3,1,2,3,nan\n1,0.1,nan,0.3,1,2,3,0\n2,0.1,0.2,0.3,1,,3,0\n3,0.1,0.2,0.3,1,2,3,0\n");
  EXPECT_EQ(series.times, (std::vector{0.0, 3.0}));
  EXPECT_NE(series.notes.back().find("2 of 4 lines lack a number and are left out, the first is line 3"), std::string::npos)
      << series.notes.back();
  EXPECT_NE(refusal("t,q0,q1,q2,tau0,tau1,tau2\n1,0.1,nan,0.3,1,2,3\n").find("1 lines that all lack a number"), std::string::npos);
  EXPECT_NE(refusal("t,q0,q1,q2,tau0,tau1,tau2\n1,0.1,inf,0.3,1,2,3\n").find("expected a finite number"), std::string::npos);
}

TEST(Series, TorquesThatNoMotorBears_AreOfAnotherUnit) {
  EXPECT_NE(refusal("t,q0,q1,q2,tau0,tau1,tau2\n1,0.1,0.2,0.3,1000,-2000,3000\n")
                .find("in joint 'robot/shoulder', 111 times what its motor bears"),
            std::string::npos)
      << refusal("t,q0,q1,q2,tau0,tau1,tau2\n1,0.1,0.2,0.3,1000,-2000,3000\n");
}

TEST(Series, TimesInNanoseconds_AreRefused) {
  EXPECT_NE(refusal("timestamp,q0,q1,q2,tau0,tau1,tau2\n1700000000000000000,0.1,0.2,0.3,1,2,3\n")
                .find("got a time of 1.7e+18, expected seconds; divide milliseconds by 1000, and nanoseconds by 1e9"),
            std::string::npos);
  EXPECT_EQ(read("timestamp,q0,q1,q2,tau0,tau1,tau2\n1700000000.5,0.1,0.2,0.3,1,2,3\n").times, std::vector{1700000000.5});
}

TEST(Series, FilesThatAreNoTables_AreNamed) {
  EXPECT_NE(refusal("\xFF\xFEt").find(":1: series: got text in UTF-16, expected UTF-8"), std::string::npos);
  const auto folder = message_of([] { (void)load_series(folder_of_the_process(), *arm()); });
  EXPECT_NE(folder.find("series: got a folder, expected a CSV or NPZ file"), std::string::npos) << folder;
  EXPECT_NE(message_of([] { (void)load_series("none.csv", *arm()); }).find("none.csv: series: got no file of this name"),
            std::string::npos);
}

TEST(Series, NamesThatDoNotSayWhichJoint_AreRefused) {
  struct Case {
    const char *head, *message;
  };
  for (const Case& c : {
           Case{"t,a,b,c,d,e,f", "got no column for the position of the joint 'robot/shoulder' among 't', 'a', 'b', 'c', 'd', 'e', 'f'"},
           Case{"t,q_elbow,q_wrist,q_hip,tau_shoulder,tau_elbow,tau_wrist", "got no column for the position of the joint 'robot/shoulder'"},
           Case{"t,q_shoulder,q_elbow,q_wrist,tau_shoulder,tau_elbow,tau_hip", "got no column for the torque of the joint 'robot/wrist'"},
           Case{"t,q_shoulder,q_elbow,elbow/position,tau_shoulder,tau_elbow,tau_wrist",
                "got the columns 'q_elbow' and 'elbow/position' for the position of the joint 'robot/elbow'"},
           Case{"t,q_shoulder [deg],q_elbow [deg],q_wrist [deg],tau1,tau2,tau3",
                "got no column for the position of the joint 'robot/shoulder'"},
           Case{"t,position[0],position[1],position[2],effort[0],effort[1],effort[2]", "got no column for the position of the joint"},
           Case{"t,q0,q1,q3,tau0,tau1,tau2", "got no column for the position of the joint"},
           Case{"step,q1,q2,q3,tau1,tau2,tau3", "got no column for the time among 'step'"},
           Case{"t,time,q2,q3,tau1,tau2,tau3", "got the columns 't' and 'time' for the time"},
       }) {
    const std::string message = refusal(std::string(c.head) + "\n0.5,0.1,0.2,0.3,1,2,3\n");
    EXPECT_NE(message.find(":1: series: " + std::string(c.message)), std::string::npos) << c.head << "\n" << message;
  }
  EXPECT_NE(refusal("t,q,tau\n0.5,0.1,0.2,0.3,1,2,3\n").find("such as 'q_shoulder', in any order, or a table without a line of names"),
            std::string::npos);
  EXPECT_NE(refusal("t,q1,q2,q3,tau1,tau2,tau3\n0.5,0.1,0.2,0.3,1,2\n").find(":2: series: got 6 fields, expected 7, one for each column"),
            std::string::npos);
}

TEST(Series, JointsOfTwoRobots_AreToldApartByTheirRobot) {
  const auto model = two_arms();
  const Series series =
      read("t,/right/joint_states/elbow/position,/left/joint_states/elbow/position,tau_left/elbow,tau_right/elbow\n0,2,1,10,20\n", *model);
  EXPECT_EQ(series.q, Eigen::Vector2d(1, 2));
  EXPECT_EQ(series.tau, Eigen::Vector2d(10, 20));
  EXPECT_NE(
      refusal("t,q_elbow,q_right/elbow,tau1,tau2\n0,2,1,10,20\n", *model).find("no column for the position of the joint 'left/elbow'"),
      std::string::npos);
}

TEST(Series, JointsWithNumbersForNames_AreTakenByTheirNames) {
  const auto model = make_robot(chain({"2", "1"}));
  const Series series = read("t,q_1,q_2,tau_1,tau_2\n0,0.1,0.2,10,20\n", *model);
  EXPECT_EQ(series.q, Eigen::Vector2d(0.2, 0.1));
  EXPECT_EQ(series.tau, Eigen::Vector2d(20, 10));
}

TEST(Series, JointsOfAList_AreEveryJointOnce) {
  const auto model = arm();
  EXPECT_EQ(find_joints({"wrist", "gripper", "robot/elbow", "shoulder"}, *model, "f"), (std::vector<std::size_t>{3, 2, 0}));
  EXPECT_NE(message_of([&] {
              (void)find_joints({"wrist", "elbow"}, *model, "f");
            }).find("f: got joints 'wrist', 'elbow' with no 'robot/shoulder'"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              (void)find_joints({"wrist", "elbow", "shoulder", "robot/wrist"}, *model, "f");
            }).find("with more than one 'robot/wrist'"),
            std::string::npos);
}

TEST(Series, BlanksBetweenNumbers_SeparateThem) {
  expect_columns_of_the_arm("timestamp actual_q_0 actual_q_1 actual_q_2 tau_0 tau_1 tau_2\n0.5 0.1 0.2 0.3 1 2 3\n");  // as RTDE writes
  expect_columns_of_the_arm("5.0e-01 1.0e-01 2.0e-01 3.0e-01 1.0e+00 2.0e+00 3.0e+00\n");                              // as numpy.savetxt
  expect_columns_of_the_arm("  0.5   0.1   0.2   0.3    1    2    3  \n");
  expect_columns_of_the_arm("# t q1 q2 q3 tau1 tau2 tau3\n0.5 0.1 0.2 0.3 1 2 3\n");
}

TEST(Series, NamesInAComment_CountAlsoWithAnotherCommentOrOtherMarks) {
  expect_columns_of_the_arm("# t,tau3,tau2,tau1,q3,q2,q1\n# units: s, rad, N m\n0.5,3,2,1,0.3,0.2,0.1\n");
  expect_columns_of_the_arm(
      "# t tau3 tau2 tau1 q3 q2 q1\n0.5,3,2,1,0.3,0.2,0.1\n");  // numpy.savetxt with another delimiter than its header
  expect_columns_of_the_arm("# log of the arm of last week\n0.5,0.1,0.2,0.3,1,2,3\n");  // as many words as columns
}

TEST(Series, TimesInOtherUnits_AreConvertedWithANote) {
  for (const char* name : {"time_ms", "t [ms]", "Timestamp (ms)", "duration_ms"}) {
    const Series series = read(std::string(name) + ",q0,q1,q2,tau0,tau1,tau2\n500,0.1,0.2,0.3,1,2,3\n");
    EXPECT_EQ(series.times, std::vector{0.5}) << name;
    EXPECT_NE(series.notes.at(0).find("are taken for milliseconds"), std::string::npos) << name;
  }
  EXPECT_EQ(read("time_ns,q0,q1,q2,tau0,tau1,tau2\n1700000000500000000,0.1,0.2,0.3,1,2,3\n").times, std::vector{1700000000.5});
  const Series franka = read(
      "duration, success rate, q[0], q[1], q[2], tau_ext_hat_filtered[0], tau_ext_hat_filtered[1], tau_ext_hat_filtered[2]\n"
      "500, 1, 0.1, 0.2, 0.3, 1, 2, 3\n");
  EXPECT_EQ(franka.times, std::vector{0.5}) << "franka::logToCSV writes milliseconds";
  EXPECT_NE(refusal("duration,q0,q1,q2,tau0,tau1,tau2\n0.5,0.1,0.2,0.3,1,2,3\n").find("no column for the time"), std::string::npos);
}

TEST(Series, WholeTimes_MayBeMilliseconds) {
  const std::string columns = ",q0,q1,q2,tau0,tau1,tau2\n";
  std::string rows;
  for (int i = 0; i < 20; ++i) rows += std::to_string(8 * i) + ",0.1,0.2,0.3,1,2,3\n";
  EXPECT_NE(read("t" + columns + rows).notes.at(0).find("all times are whole numbers, taken for seconds"), std::string::npos);
  const auto notes = read("time_ms" + columns + rows).notes;
  ASSERT_EQ(notes.size(), 1u) << "the unit is in the name";
  EXPECT_NE(notes[0].find("taken for milliseconds"), std::string::npos) << notes[0];
}

TEST(Series, AnglesInDegrees_AreRefused) {
  EXPECT_NE(
      refusal("t,q0,q1,q2,tau0,tau1,tau2\n1,10,-90,30,1,2,3\n").find("whose limits are -2 and 2, expected rad; multiply degrees by pi/180"),
      std::string::npos);
  EXPECT_EQ(read("t,q0,q1,q2,tau0,tau1,tau2\n1,2.5,-3,3,1,2,3\n").times.size(), 1u) << "beyond its limits, but may be radians";
}

TEST(Series, FilesOfOtherFormats_AreNamedAndSayWhatToDo) {
  using std::string_literals::operator""s;
  for (const auto& [bytes, what] :
       std::vector<std::pair<std::string, std::string>>{{"PAR1\x15\0\0"s, "a Parquet file, expected a CSV or NPZ file; pandas"},
                                                        {"SQLite format 3\0"s, "a SQLite database"},
                                                        {"#ROSBAG V2.0\n"s, "a bag of ROS 1"},
                                                        {"\x93NUMPY\x01\0"s, "one array of NumPy"},
                                                        {"\x1f\x8b\x08\0"s, "a file packed by gzip, expected a CSV or NPZ file; gunzip"},
                                                        {"{\"t\": [0, 1]}"s, "JSON"},
                                                        {"t,q\0"s, "a byte 0, expected text"}}) {
    const std::string message = refusal(bytes);
    EXPECT_NE(message.find("series: got " + what), std::string::npos) << message;
    EXPECT_TRUE(std::ranges::all_of(message, [](char c) { return c >= ' ' && c < 0x7f; })) << message;
  }
}

TEST(Series, WordsForNoNumber_AreNoMoments) {
  for (const char* word : {"null", "N/A", "NA", "None", "<NA>"}) {
    const Series series = read("t,q0,q1,q2,tau0,tau1,tau2\n0,0.1,0.2,0.3,1,2,3\n1,0.1," + std::string(word) + ",0.3,1,2,3\n");
    EXPECT_EQ(series.times, std::vector{0.0}) << word;
  }
}

TEST(Series, ColumnThatIsThereTwice_IsNamed) {
  EXPECT_NE(refusal("t,q0,q1,q2,tau0,tau1,tau2,tau2\n0,0.1,0.2,0.3,1,2,3,4\n")
                .find(":1: series: got the column 'tau2' more than once, expected every name once"),
            std::string::npos);
}

}  // namespace
}  // namespace stiction::sensing::test
