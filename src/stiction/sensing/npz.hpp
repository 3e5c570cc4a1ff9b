#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

namespace stiction::sensing {

/// Arrays of a file of numpy.savez, by name: of one axis as a column, of two as a matrix; float64 or float32.
/// @throws core::InvalidInput: no such archive, a compressed or damaged one, an array of another kind
std::map<std::string, Eigen::MatrixXd> read_npz(const std::filesystem::path& file);

}  // namespace stiction::sensing
