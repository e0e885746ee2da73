#!/usr/bin/env bash
# Makes what DDS Security needs: one authority, and a folder with an identity for each program or person.
set -euo pipefail

readonly authority_days=3650
days=1095 # of an identity

usage() {
  cat <<'END'
usage: identities.sh [--days N] FOLDER ROLE[=NAME]...

  ROLE  gateway   writes what the gateway says; hears requests, references and commands
        operator  hears everything; writes requests, references, commands and scores
        observer  hears everything; writes nothing
  NAME  of the identity and its folder; as the role when none is given
  --days N  how long the identities hold (1095)

The first time it makes the authority, in FOLDER/authority: whoever has its key.pem can make himself an operator, so keep it
on one machine. Later it adds identities. FOLDER/NAME goes to the machine of its owner, by a way that nobody looks into,
and is what [bus] security or motionlab --security names. An identity that exists is never made anew: delete it first.
END
}

wrong_usage() {
  echo "identities.sh: $1; see identities.sh --help" >&2
  exit 64
}

# The topics by which the gateway is asked, and commanded.
readonly requests=(motionlab/mode_request motionlab/reference) commands=(motionlab/arm_command motionlab/winch_command)

# What a role may write and hear, as the names of topics.
rights() {
  case $1 in
    gateway)
      writes=('motionlab/*')
      hears=("${requests[@]}" "${commands[@]}")
      ;;
    operator)
      writes=("${requests[@]}" "${commands[@]}" motionlab/score)
      hears=('*')
      ;;
    observer)
      writes=()
      hears=('*')
      ;;
    *) wrong_usage "there is no role $1" ;;
  esac
}

# topics ELEMENT NAME...: what may be published or subscribed to, in the default partition and in that of a simulation.
topics() {
  (($# > 1)) || return 0
  printf '<%s><topics>%s</topics><partitions><partition>*</partition></partitions></%s>' \
    "$1" "$(printf '<topic>%s</topic>' "${@:2}")" "$1"
}

# Everything is signed for each of its readers: with one key for all of them, who may only read could write in another's name.
governance() {
  cat <<END
<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>232</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT_WITH_ORIGIN_AUTHENTICATION</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
END
}

# permissions SUBJECT ROLE
permissions() {
  local writes hears
  rights "$2"
  cat <<END
<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name="$2">
      <subject_name>$1</subject_name>
      <validity>
        <not_before>$(date -u -d '-1 day' +%Y-%m-%dT%H:%M:%S)</not_before>
        <not_after>$(date -u -d "+$days days" +%Y-%m-%dT%H:%M:%S)</not_after>
      </validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>232</max></id_range></domains>
        $(topics publish "${writes[@]}")
        $(topics subscribe "${hears[@]}")
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
END
}

new_key=(-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -sha256)

# quietly COMMAND...: what openssl says is of use only when it fails.
quietly() {
  local said
  said=$("$@" 2>&1) || {
    printf 'identities.sh: openssl refuses:\n%s\n' "$said" >&2
    exit 1
  }
}

sign() { # FILE SIGNED
  quietly openssl smime -sign -text -in "$1" -out "$2" -signer "$authority/certificate.pem" -inkey "$authority/key.pem"
}

make_authority() {
  [[ ! -f $authority/key.pem ]] || return 0
  mkdir -p "$authority"
  quietly openssl req -x509 "${new_key[@]}" -days $authority_days -subj /O=motionlab/CN=authority \
    -keyout "$authority/key.pem" -out "$authority/certificate.pem"
  governance >"$made/governance.xml"
  sign "$made/governance.xml" "$authority/governance.smime"
  echo "made the authority in $authority; keep its key.pem on this machine"
}

make_identity() { # ROLE NAME
  local identity=$folder/$2 subject
  [[ ! -e $identity ]] || wrong_usage "$identity is there already"
  rm -rf "$made/identity"
  mkdir "$made/identity"
  quietly openssl req "${new_key[@]}" -subj "/O=motionlab/CN=$2" -keyout "$made/identity/key.pem" -out "$made/request"
  quietly openssl x509 -req -in "$made/request" -days "$days" -sha256 -CA "$authority/certificate.pem" \
    -CAkey "$authority/key.pem" -set_serial "0x$(openssl rand -hex 16)" -out "$made/identity/certificate.pem"
  subject=$(openssl x509 -noout -subject -nameopt RFC2253 -in "$made/identity/certificate.pem")
  permissions "${subject#subject=}" "$1" >"$made/permissions.xml"
  sign "$made/permissions.xml" "$made/identity/permissions.smime"
  cp "$authority/certificate.pem" "$made/identity/authority.pem"
  cp "$authority/governance.smime" "$made/identity/"
  mv "$made/identity" "$identity"
  echo "made $identity: $1"
}

if [[ ${1:-} == --help || ${1:-} == -h ]]; then
  usage
  exit 0
fi
if [[ ${1:-} == --days ]]; then
  [[ ${2:-} =~ ^[1-9][0-9]{0,4}$ ]] || wrong_usage "--days ${2:-} is no number of days"
  days=$2
  shift 2
fi
(($# >= 2)) || wrong_usage "a folder and at least one role are needed"
command -v openssl >/dev/null || wrong_usage "openssl is not installed"
folder=$1
shift
for wanted in "$@"; do
  rights "${wanted%%=*}"
  [[ ${wanted#*=} =~ ^[a-z][a-z0-9-]{0,63}$ && ${wanted#*=} != authority ]] ||
    wrong_usage "${wanted#*=} is no name: small letters, digits and - only, and not authority"
done

umask 077
authority=$folder/authority
mkdir -p "$folder"
made=$(mktemp -d -p "$folder")
trap 'rm -rf "$made"' EXIT
make_authority
for wanted in "$@"; do make_identity "${wanted%%=*}" "${wanted#*=}"; done
