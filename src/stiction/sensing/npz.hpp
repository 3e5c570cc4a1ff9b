#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stiction::sensing {

/// The arrays of a file of numpy.savez, by name.
struct NpzArrays {
  std::map<std::string, Eigen::MatrixXd> numbers;  ///< float64 or float32; arrays with one axis as a column, with two axes as a matrix
  std::map<std::string, std::vector<std::string>> words;  ///< string arrays with one axis, in UTF-8
};

/// @throws core::InvalidInput: no such archive, a compressed or damaged one, an array of another kind
NpzArrays read_npz(const std::filesystem::path& file);

}  // namespace stiction::sensing
