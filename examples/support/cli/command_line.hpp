#pragma once

// A program's options, read by CLI11. Its headers take longer to compile than most programs, so only
// command_line.cpp includes them.

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace cageform_support {

/// An option of a CommandLine.
class CommandOption {
public:
    explicit CommandOption(CLI::Option* option)
        : option_(option) {}

    CommandOption& required();
    CommandOption& show_default(); ///< the value before parsing, in the help
    CommandOption& show_default(const std::string& text);
    CommandOption& range(int least, int most);
    CommandOption& range(double least, double most);
    CommandOption& one_of(const std::vector<std::string>& words);
    CommandOption& check(const std::function<std::string(const std::string&)>& fault); ///< empty: none
    CommandOption& count(int least, int most);                                         ///< how many values
    CommandOption& excludes(const CommandOption& other);
    CommandOption& in_order(); ///< its function is called when the option is met: in the order of the words
    CommandOption& ends_with(const std::vector<std::string>& endings); ///< such as ".svg", of a file to write

    CommandOption& rarely_needed(); ///< --help leaves it to --help-all

    bool is_given() const; ///< after parsing

private:
    CLI::Option* option_;
};

/// Every program has --help, --help-all, which lists rare options and formats of files too, and --version,
/// which prints its name and the library's version.
class CommandLine {
public:
    explicit CommandLine(const std::string& description);
    ~CommandLine();

    /// "-o,--output" is an option, "figure" an argument in its place. `value` is set by parse().
    CommandOption add(const std::string& name, std::string& value, const std::string& help);
    CommandOption add(const std::string& name, std::vector<std::string>& value, const std::string& help);
    CommandOption add(const std::string& name, std::vector<double>& value, const std::string& help);
    CommandOption add(const std::string& name, int& value, const std::string& help);
    CommandOption add(const std::string& name, std::size_t& value, const std::string& help);
    CommandOption add(const std::string& name, double& value, const std::string& help);
    CommandOption add_flag(const std::string& name, bool& value, const std::string& help);
    /// Options whose value goes to a function.
    CommandOption add_text(const std::string& name, const std::function<void(const std::string&)>& take,
                           const std::string& help);
    /// An option that `parse` reads into `value`; it returns why a word is no value, or "".
    template <class T, class Parse>
    CommandOption add_parsed(const std::string& name, T& value, const Parse& parse, const std::string& help) {
        const auto fault = [parse](const std::string& word) {
            T ignored{};
            return std::string(parse(word, ignored));
        };
        return add_text(
                   name, [&value, parse](const std::string& word) { (void)parse(word, value); }, help)
            .check(fault);
    }
    CommandOption add_number(const std::string& name, const std::function<void(double)>& take,
                             const std::string& help);
    /// Sets the examples in the help; the program's name is put before each.
    void set_examples(std::vector<std::string> arguments);
    /// Below the options in --help-all: how the files look that the program takes.
    void set_footer(const std::string& text);

    /// Nothing, or the code to exit with: 0 after --help and --version, 1 where the words are wrong and
    /// stderr says why.
    [[nodiscard]] std::optional<int> parse(int argc, char** argv);

private:
    std::string footer(bool all) const;

    std::unique_ptr<CLI::App> app_;
    std::vector<std::string> examples_;
    std::string formats_;
};

} // namespace cageform_support
