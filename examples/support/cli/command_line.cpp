#include "cli/command_line.hpp"

#include "io/atomic_file.hpp"
#include "io/messages.hpp"

#include <cageform/version.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <utility>

namespace cageform_support {

namespace {

/// Former and current values of options.
constexpr std::pair<const char*, const char*> older_words[]{{"curved", "curved-green"},
                                                            {"float", "scalar"},
                                                            {"keep", "keep-in-place"},
                                                            {"nearest", "nearest-boundary"}};

/// Accepts only decimal whole numbers. CLI11 itself parses 010 as octal, and -1 as the largest size.
CLI::Validator decimal(bool with_sign) {
    const auto fault = [with_sign](std::string& text) -> std::string {
        const std::size_t first = with_sign && text.starts_with('-') ? 1 : 0;
        const bool digits = first < text.size() && text.find_first_not_of("0123456789", first) == text.npos;
        if (!digits) return "\"" + text + "\" is not a whole number" + (with_sign ? "" : " from 0");
        const std::size_t zeros = std::min(text.find_first_not_of('0', first), text.size() - 1) - first;
        if (text.size() - first - zeros > 18) return text + " is too large";
        text.erase(first, zeros);
        return {};
    };
    return {fault, ""};
}

const char* const rare_options = "Rarely needed";

/// Hides rarely needed options, unless --help-all is given.
class HelpFormatter : public CLI::Formatter {
public:
    explicit HelpFormatter(bool all)
        : all_(all) {}
    std::string make_group(std::string group, bool is_positional,
                           std::vector<const CLI::Option*> options) const override {
        if (!all_ && group == rare_options) return {};
        return CLI::Formatter::make_group(std::move(group), is_positional, std::move(options));
    }

private:
    bool all_;
};

} // namespace

CommandOption& CommandOption::required() {
    option_->required();
    return *this;
}
CommandOption& CommandOption::show_default() {
    option_->capture_default_str();
    return *this;
}
CommandOption& CommandOption::show_default(const std::string& text) {
    option_->default_str(text);
    return *this;
}
CommandOption& CommandOption::range(int least, int most) {
    option_->check(CLI::Range(least, most));
    return *this;
}
CommandOption& CommandOption::range(double least, double most) {
    option_->check(CLI::Range(least, most));
    return check([](const std::string& text) { // CLI::Range accepts NaN
        return std::isnan(std::strtod(text.c_str(), nullptr)) ? text + " is not a number" : std::string();
    });
}
CommandOption& CommandOption::one_of(const std::vector<std::string>& words) {
    option_->transform([words](std::string given) {
        for (const auto& [older, newer] : older_words) {
            if (given == older && std::find(words.begin(), words.end(), newer) != words.end()) given = newer;
        }
        return given;
    });
    option_->check(CLI::IsMember(words));
    return *this;
}
CommandOption& CommandOption::check(const std::function<std::string(const std::string&)>& fault) {
    option_->check(fault);
    return *this;
}
CommandOption& CommandOption::count(int least, int most) {
    option_->expected(least, most);
    return *this;
}
CommandOption& CommandOption::excludes(const CommandOption& other) {
    option_->excludes(other.option_);
    return *this;
}
CommandOption& CommandOption::in_order() {
    option_->trigger_on_parse();
    return *this;
}
CommandOption& CommandOption::ends_with(const std::vector<std::string>& endings) {
    option_->check([endings](const std::string& path) -> std::string {
        const std::string ending = lowercase_extension(path);
        std::string known;
        for (const std::string& one : endings) {
            if (ending == one) return {};
            known += (known.empty() ? "" : " or ") + one;
        }
        return "\"" + path + "\" does not end with " + known + "; the ending selects the format";
    });
    return *this;
}
CommandOption& CommandOption::rarely_needed() {
    option_->group(rare_options);
    return *this;
}
bool CommandOption::is_given() const {
    return option_->count() > 0;
}

CommandLine::CommandLine(const std::string& description)
    : app_(std::make_unique<CLI::App>(description)) {
    app_->set_version_flag(
        "--version",
        [this] {
            return std::filesystem::path(app_->get_name()).filename().string() + " (cageform) " +
                   CAGEFORM_VERSION_STRING;
        },
        "Print the version and exit");
    app_->set_help_all_flag("--help-all", "Print this help with the rarely needed options, and exit");
    app_->failure_message([](const CLI::App* app, const CLI::Error& error) {
        const CLI::Error shown(error.get_name(), printable(error.what()), error.get_exit_code());
        return CLI::FailureMessage::simple(app, shown);
    });
}
CommandLine::~CommandLine() = default;

CommandOption CommandLine::add(const std::string& name, std::string& value, const std::string& help) {
    return CommandOption(app_->add_option(name, value, help));
}
CommandOption CommandLine::add(const std::string& name, std::vector<std::string>& value,
                               const std::string& help) {
    return CommandOption(app_->add_option(name, value, help));
}
CommandOption CommandLine::add(const std::string& name, std::vector<double>& value, const std::string& help) {
    return CommandOption(app_->add_option(name, value, help));
}
CommandOption CommandLine::add(const std::string& name, int& value, const std::string& help) {
    return CommandOption(app_->add_option(name, value, help)->transform(decimal(true)));
}
CommandOption CommandLine::add(const std::string& name, std::size_t& value, const std::string& help) {
    return CommandOption(app_->add_option(name, value, help)->transform(decimal(false)));
}
CommandOption CommandLine::add(const std::string& name, double& value, const std::string& help) {
    return CommandOption(app_->add_option(name, value, help));
}
CommandOption CommandLine::add_flag(const std::string& name, bool& value, const std::string& help) {
    return CommandOption(app_->add_flag(name, value, help));
}
void CommandLine::add_png(bool& png, int& width) {
    add_flag("--png", png, "also render it, to the same name with .png");
    add("--png-width", width, "the width of the PNG file, in pixels").range(1, 16384).show_default();
}
CommandOption CommandLine::add_text(const std::string& name,
                                    const std::function<void(const std::string&)>& take,
                                    const std::string& help) {
    return CommandOption(app_->add_option_function<std::string>(name, take, help));
}
CommandOption CommandLine::add_number(const std::string& name, const std::function<void(double)>& take,
                                      const std::string& help) {
    return CommandOption(app_->add_option_function<double>(name, take, help));
}
void CommandLine::set_examples(std::vector<std::string> arguments) {
    examples_ = std::move(arguments);
}
void CommandLine::set_footer(const std::string& text) {
    formats_ = text;
}

std::string CommandLine::footer(bool all) const {
    const std::string name = std::filesystem::path(app_->get_name()).filename().string();
    std::string text = examples_.empty() ? "" : examples_.size() == 1 ? "Example:\n" : "Examples:\n";
    for (const std::string& arguments : examples_) text += "  " + name + ' ' + arguments + '\n';
    if (all) return text + (formats_.empty() ? "" : '\n' + formats_);
    const auto rare =
        app_->get_options([](const CLI::Option* option) { return option->get_group() == rare_options; });
    if (rare.empty() && formats_.empty()) return text;
    return text + "\n--help-all " +
           (rare.empty() ? "also describes" : "lists " + std::to_string(rare.size()) + " more options") +
           (rare.empty() || formats_.empty() ? "" : " and describes") +
           (formats_.empty() ? ".\n" : " the file formats.\n");
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
    app_->name(argc > 0 ? argv[0] : "");
    const auto asks = [&](std::string_view word) {
        return std::any_of(argv + 1, argv + argc, [&](const char* given) { return given == word; });
    };
    const bool all = asks("--help-all");
    app_->footer(footer(all));
    app_->formatter(std::make_shared<HelpFormatter>(all));
    try {
        app_->parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app_->exit(error) == 0 ? 0 : 1;
    }
    return std::nullopt;
}

} // namespace cageform_support
