#include <fmt/format.h>

#include <iostream>

#include "command.h"
#include "io/hdf5_store.h"

namespace tissue::cli {
namespace {

void run(const std::string& file) {
    const Hdf5Reader in(file, "");
    const std::string space =
        in.has_attribute("/", "dimension") ? fmt::format(" in {} dimensions", in.number_attribute("/", "dimension")) : "";
    std::cout << fmt::format("{}: {} of study '{}'{}, format {}, tissuectl {}, seed {:.0f}\n  {}\n", file,
                             in.text_attribute("/", "kind"), in.text_attribute("/", "study"), space,
                             in.number_attribute("/", "format_version"), in.text_attribute("/", "version"),
                             in.number_attribute("/", "seed"), in.text_attribute("/", "command"));
    for (const std::string& line : in.describe()) std::cout << "  " << line << '\n';
}

}  // namespace

void add_info(CLI::App& app, const Invocation&) {
    auto file = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("info", "Print the contents of an HDF5 file of this project.");
    command->add_option("file", *file, "cases.h5 or model.h5")->required()->type_name("FILE");
    command->callback([file] { run(*file); });
}

}  // namespace tissue::cli
