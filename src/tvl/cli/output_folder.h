// The folder a run writes its results to.
#pragma once

#include <string>

namespace tvl {

// Makes the folder where it is missing, and tries out that every result can be written there:
// better now than after an hour. Throws InputError naming the folder or file and what is wrong.
void PrepareOutputFolder(const std::string& folder);

// Removes the results of an earlier run, also those this run may not write, such as the truth or
// pictures of loops. Other files stay.
void RemoveOldResults(const std::string& folder);

}  // namespace tvl
