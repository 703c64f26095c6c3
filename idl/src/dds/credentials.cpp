// SPDX-License-Identifier: Apache-2.0
// Certificates, keys and signatures of the closed mode. The library reports only that it refuses
// them; this code finds the reason.
#include "dds/credentials.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wire/participant.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509_vfy.h>

#include <cerrno>
#include <memory>
#include <string_view>
#include <system_error>

namespace vdrive::wire {
namespace {

template <auto kFree>
struct Free {
  template <typename Thing>
  void operator()(Thing* thing) const noexcept {
    kFree(thing);
  }
};

using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Store = std::unique_ptr<X509_STORE, Free<X509_STORE_free>>;
using StoreContext = std::unique_ptr<X509_STORE_CTX, Free<X509_STORE_CTX_free>>;
using Signature = std::unique_ptr<PKCS7, Free<PKCS7_free>>;

/// A list that does not own its certificates.
using Signers = std::unique_ptr<STACK_OF(X509), Free<[](STACK_OF(X509) * list) {
                                  sk_X509_free(list);
                                }>>;

[[noreturn]] void refuse(const std::filesystem::path& file, std::string_view what) {
  throw NetworkError("network security: " + escaped(file.string(), kShownOfMessage) + ": " +
                     std::string(what));
}

Bio open(const std::filesystem::path& file) {
  errno = 0;
  Bio bio(BIO_new_file(file.c_str(), "r"));
  if (!bio || std::filesystem::is_directory(file)) {
    refuse(file, "cannot be read: " + std::generic_category().message(errno == 0 ? EISDIR : errno));
  }
  return bio;
}

Certificate read_certificate(const std::filesystem::path& file) {
  Certificate certificate(PEM_read_bio_X509(open(file).get(), nullptr, nullptr, nullptr));
  if (!certificate) refuse(file, "is not a certificate in PEM format");
  return certificate;
}

int no_pass_phrase(char* /*buffer*/, int /*size*/, int /*writes*/, void* /*data*/) {
  return -1;
}

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const auto size = BIO_get_mem_data(bio, &data);  // NOLINT(*-cstyle-cast)
  return {data, static_cast<std::size_t>(size)};
}

std::string date_of(const ASN1_TIME* time) {
  const Bio bio(BIO_new(BIO_s_mem()));
  ASN1_TIME_print(bio.get(), time);
  return text_of(bio.get());
}

void check_dates(const std::filesystem::path& file, const X509* certificate) {
  const ASN1_TIME* const begin = X509_get0_notBefore(certificate);
  const ASN1_TIME* const end = X509_get0_notAfter(certificate);
  if (X509_cmp_current_time(end) < 0) refuse(file, "expired at " + date_of(end));
  if (X509_cmp_current_time(begin) > 0) refuse(file, "is not valid before " + date_of(begin));
}

}  // namespace

std::string check_identity(const std::filesystem::path& ca_file,
                           const std::filesystem::path& certificate_file,
                           const std::filesystem::path& key_file) {
  const Certificate ca = read_certificate(ca_file);
  const Certificate certificate = read_certificate(certificate_file);
  check_dates(ca_file, ca.get());
  check_dates(certificate_file, certificate.get());
  const Key key(PEM_read_bio_PrivateKey(open(key_file).get(), nullptr, no_pass_phrase, nullptr));
  if (!key) refuse(key_file, "is not a private key in PEM format without a pass phrase");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    refuse(key_file, "is not the key of " + escaped(certificate_file.string(), kShownOfMessage));
  }
  const Store store(X509_STORE_new());
  X509_STORE_add_cert(store.get(), ca.get());
  const StoreContext context(X509_STORE_CTX_new());
  X509_STORE_CTX_init(context.get(), store.get(), certificate.get(), nullptr);
  if (X509_verify_cert(context.get()) != 1) {
    refuse(certificate_file,
           "was not issued by " + escaped(ca_file.string(), kShownOfMessage) + ": " +
               X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get())));
  }
  const Bio subject(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(subject.get(), X509_get_subject_name(certificate.get()), 0, XN_FLAG_RFC2253);
  ERR_clear_error();
  return text_of(subject.get());
}

std::string verified_text(const std::filesystem::path& ca_file,
                          const std::filesystem::path& document) {
  const Certificate ca = read_certificate(ca_file);
  check_dates(ca_file, ca.get());
  BIO* signed_part = nullptr;
  const Signature signature(SMIME_read_PKCS7(open(document).get(), &signed_part));
  const Bio content(signed_part);
  if (!signature || !content) refuse(document, "is not a signed S/MIME document");
  // Only the CA itself signs: a certificate sent with the document proves nothing.
  const Signers signers(sk_X509_new_null());
  sk_X509_push(signers.get(), ca.get());
  const Bio text(BIO_new(BIO_s_mem()));
  if (PKCS7_verify(signature.get(), signers.get(), nullptr, content.get(), text.get(),
                   PKCS7_TEXT | PKCS7_NOINTERN | PKCS7_NOVERIFY) != 1) {
    ERR_clear_error();
    refuse(document, "was not signed by " + escaped(ca_file.string(), kShownOfMessage) +
                         ", or was changed since");
  }
  return text_of(text.get());
}

}  // namespace vdrive::wire
