#pragma once

#include <string>

namespace palpate::app {

/// Opens an address in the browser of the desktop; does nothing where there is no desktop or no browser.
void open_browser(const std::string& address);

}  // namespace palpate::app
