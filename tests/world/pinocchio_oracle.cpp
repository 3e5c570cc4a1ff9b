// Prints the pose of every link of a URDF by Pinocchio: pinocchio_oracle FILE, then on stdin one line "joint value" per movable joint
// for each configuration, closed by a line "end"; per link "name r00 r01 … r22 x y z". A program of its own, because Pinocchio's wheel
// and code compiled for AVX do not agree on how Eigen frees memory.
#include <pinocchio/fwd.hpp>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  pinocchio::Model model;
  pinocchio::urdf::buildModel(argv[1], model);
  pinocchio::Data data(model);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(model.nq);
  for (std::string name; std::cin >> name;) {
    if (name != "end") {
      double value = 0;
      if (!(std::cin >> value) || !model.existJointName(name)) return 2;
      const auto& joint = model.joints[model.getJointId(name)];
      if (joint.nq() == 2) {  // continuous: (cos, sin)
        q[joint.idx_q()] = std::cos(value);
        q[joint.idx_q() + 1] = std::sin(value);
      } else {
        q[joint.idx_q()] = value;
      }
      continue;
    }
    pinocchio::framesForwardKinematics(model, data, q);
    for (std::size_t f = 0; f < model.frames.size(); ++f) {
      if (model.frames[f].type != pinocchio::BODY) continue;
      std::printf("%s", model.frames[f].name.c_str());
      const auto& X = data.oMf[f];
      for (int i = 0; i < 9; ++i) std::printf(" %.17g", X.rotation()(i / 3, i % 3));
      for (int i = 0; i < 3; ++i) std::printf(" %.17g", X.translation()[i]);
      std::printf("\n");
    }
  }
  return 0;
}
