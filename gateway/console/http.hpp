/// @file  What the console answers to HTTP, as a function of the request: the page, /config.json, and
/// /settle.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/console/assets.hpp"

namespace motionlab::console {

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// Who may ask.
struct Neighbours {
  std::vector<std::string> host_names;  ///< of this machine, besides its addresses and localhost
  std::vector<std::string>
      allowed_origins;  ///< pages from elsewhere that may look on, "https://app.foxglove.dev"

  /// Whether the request was meant for us. A page from elsewhere whose name was bent to our address (DNS
  /// rebinding) names itself in `Host`; addresses and our own names cannot be bent.
  [[nodiscard]] bool host_is_ours(std::string_view host) const;
  /// Whether whoever runs in a browser may talk to us: our own page, pages and programs of this machine, and
  /// those that were allowed. No origin at all: not a browser.
  [[nodiscard]] bool origin_may(std::string_view origin, std::string_view host) const;
};

/// "/settle" asks for rest, from anyone, without a token; what it says is told by `settle_asked`.
enum class Kind { page, settle };

/// The answer to a request that is no upgrade.
/// @param kind  set to `settle` when the request asks for it and may; then the caller settles, and the answer
/// is
///              built by `settle_answer`
[[nodiscard]] Response answer(const Request& request, const Assets& assets, const Neighbours& neighbours,
                              Kind& kind);

/// @param listeners  gateways that hear the request now
[[nodiscard]] Response settle_answer(const Request& request, std::size_t listeners);

/// A refusal with a sentence.
[[nodiscard]] Response refusal(const Request& request, boost::beast::http::status status,
                               std::string_view sentence);

}  // namespace motionlab::console
