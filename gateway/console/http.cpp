#include "gateway/console/http.hpp"

#include <boost/asio/ip/address.hpp>

#include <algorithm>

namespace motionlab::console {
namespace {

namespace http = boost::beast::http;

std::string_view view(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

/// "lab-pc:8080" → "lab-pc", "[::1]:8080" → "::1".
std::string_view name_of(std::string_view host) {
  if (host.starts_with('['))
    return host.substr(1, host.find(']') == host.npos ? host.npos : host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

/// "http://lab-pc:8080" → "lab-pc:8080".
std::string_view host_of(std::string_view origin) {
  const auto scheme = origin.find("://");
  return scheme == origin.npos ? std::string_view{} : origin.substr(scheme + 3);
}

bool is_loopback(std::string_view name) {
  if (name == "localhost") return true;
  boost::system::error_code failed;
  const auto address = boost::asio::ip::make_address(std::string{name}, failed);
  return !failed && address.is_loopback();
}

Response with_headers(const Request& request, http::status status) {
  Response response{status, request.version()};
  response.keep_alive(request.keep_alive());
  response.set(http::field::server, "motionlab-console");
  response.set(http::field::cache_control, "no-cache");  // asks each time; an unchanged file costs a 304
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set(
      "Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  return response;
}

Response with_text(const Request& request, http::status status, std::string_view text) {
  Response response = with_headers(request, status);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = std::string{text} + "\n";
  response.prepare_payload();
  return response;
}

}  // namespace

bool Neighbours::host_is_ours(std::string_view host) const {
  const std::string_view name = name_of(host);
  if (name == "localhost") return true;
  boost::system::error_code failed;
  boost::asio::ip::make_address(std::string{name}, failed);
  return !failed || std::ranges::find(host_names, name) != host_names.end();
}

bool Neighbours::origin_may(std::string_view origin, std::string_view host) const {
  if (origin.empty() || origin == "file://")
    return true;  // no browser; a program that shows pages of its own
  if (host_of(origin) == host || is_loopback(name_of(host_of(origin)))) return true;
  return std::ranges::find(allowed_origins, origin) != allowed_origins.end();
}

Response refusal(const Request& request, http::status status, std::string_view sentence) {
  return with_text(request, status, sentence);
}

Response settle_answer(const Request& request, std::size_t listeners) {
  return listeners > 0
             ? with_text(request, http::status::ok, "settle was asked of the gateway")
             : with_text(request, http::status::service_unavailable,
                         "no gateway listens: settle was sent, but nobody is known to have heard it");
}

Response answer(const Request& request, const Assets& assets, const Neighbours& neighbours, Kind& kind) {
  kind = Kind::page;
  const std::string_view host = view(request[http::field::host]), origin = view(request[http::field::origin]);
  if (!neighbours.host_is_ours(host)) {
    return refusal(request, http::status::misdirected_request,
                   "this is no name of the console: use its address, or start it with --host-name");
  }
  const std::string_view target = view(request.target());
  const std::string_view path = target.substr(0, target.find('?'));
  if (path == "/settle") {
    if (request.method() != http::verb::post) {
      Response response = with_text(request, http::status::method_not_allowed, "settle is asked with POST");
      response.set(http::field::allow, "POST");
      return response;
    }
    if (!neighbours.origin_may(origin, host)) {
      return refusal(request, http::status::forbidden, "a page from elsewhere may not ask");
    }
    kind = Kind::settle;
    return {};
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Response response = with_text(request, http::status::method_not_allowed, "the page is read with GET");
    response.set(http::field::allow, "GET, HEAD");
    return response;
  }
  const Asset* const asset = assets.find(path);
  if (!asset) return with_text(request, http::status::not_found, "there is no such file");
  const bool unchanged = view(request[http::field::if_none_match]) == asset->etag;
  Response response = with_headers(request, unchanged ? http::status::not_modified : http::status::ok);
  response.set(http::field::etag, asset->etag);
  response.set(http::field::content_type, asset->type);
  if (unchanged) return response;
  if (request.method() == http::verb::head) {
    response.content_length(asset->bytes.size());
    return response;
  }
  response.body() = asset->bytes;
  response.prepare_payload();
  return response;
}

}  // namespace motionlab::console
