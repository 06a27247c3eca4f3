#pragma once

// Command line options, parsed by CLI11. Only command_line.cpp includes its headers, which are slow to
// compile.

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
    CommandOption& show_default(); ///< shows the value before parsing in the help
    CommandOption& show_default(const std::string& text);
    CommandOption& range(int least, int most);
    CommandOption& range(double least, double most);
    CommandOption& one_of(const std::vector<std::string>& words);
    CommandOption&
    check(const std::function<std::string(const std::string&)>& fault); ///< returns an error, or empty
    CommandOption& count(int least, int most);                          ///< number of values
    CommandOption& excludes(const CommandOption& other);
    CommandOption& in_order(); ///< calls its function during parsing, in the order of the command line
    CommandOption& ends_with(const std::vector<std::string>& endings); ///< file extensions such as ".svg"

    CommandOption& rarely_needed(); ///< shown by --help-all only

    bool is_given() const; ///< after parsing

private:
    CLI::Option* option_;
};

/// The command line of a program. All programs have --help, --help-all (with rarely needed options and file
/// formats) and --version.
class CommandLine {
public:
    explicit CommandLine(const std::string& description);
    ~CommandLine();

    /// "-o,--output" is an option, "figure" a positional argument. parse() sets `value`.
    CommandOption add(const std::string& name, std::string& value, const std::string& help);
    CommandOption add(const std::string& name, std::vector<std::string>& value, const std::string& help);
    CommandOption add(const std::string& name, std::vector<double>& value, const std::string& help);
    CommandOption add(const std::string& name, int& value, const std::string& help);
    CommandOption add(const std::string& name, std::size_t& value, const std::string& help);
    CommandOption add(const std::string& name, double& value, const std::string& help);
    CommandOption add_flag(const std::string& name, bool& value, const std::string& help);
    /// Options whose value is passed to a function.
    CommandOption add_text(const std::string& name, const std::function<void(const std::string&)>& take,
                           const std::string& help);
    /// An option whose word parse(word, value) reads into `value`; `parse` returns the error, or "".
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
    /// Adds --png and --png-width of programs that write SVG.
    void add_png(bool& png, int& width);
    /// Sets the examples in the help, without the program's name.
    void set_examples(std::vector<std::string> arguments);
    /// Text after the options in --help-all: file formats.
    void set_footer(const std::string& text);

    /// Returns the exit code if the program should exit: 0 after --help and --version, 1 after an error,
    /// which is printed.
    [[nodiscard]] std::optional<int> parse(int argc, char** argv);

private:
    std::string footer(bool all) const;

    std::unique_ptr<CLI::App> app_;
    std::vector<std::string> examples_;
    std::string formats_;
};

} // namespace cageform_support
