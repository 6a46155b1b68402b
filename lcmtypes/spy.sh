#!/usr/bin/env bash
# lcmtypes/spy.sh [URL] [JAR…]
#
# Starts lcm-spy with knap's message types. URL is the run's (default: $LCM_DEFAULT_URL, then LCM's own default);
# JAR is build/release/bin/knap_types.jar unless others are named.
# Debian's own start script passes an option that Java 17 refuses, hence the plain command.
set -euo pipefail

case ${1-} in
  -h | --help)
    sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
url=${1:-${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}}
jars=("${@:2}")
if ((${#jars[@]} == 0)); then
  jars=("$(dirname -- "${BASH_SOURCE[0]}")"/../build/release/bin/knap_types.jar)
fi
for jar in "${jars[@]}"; do
  if [[ ! -f $jar ]]; then
    echo "spy.sh: $jar does not exist; ./run.sh and ./test.sh build it" >&2
    exit 2
  fi
done

# A headless Java has every class of the desktop and none of its windows: the library that draws is the difference.
java_home=$(dirname -- "$(dirname -- "$(readlink -f -- "$(command -v java || echo /)")")")
# LCM's own jar is liblcm-java.jar from LCM 1.4 on.
classpath=
for name in lcm liblcm-java jchart2d xmlgraphics-commons jide-oss; do
  if [[ -f /usr/share/java/$name.jar ]]; then classpath+=/usr/share/java/$name.jar:; fi
done
if [[ $classpath != *lcm*jchart2d* ]] || [[ ! -f $java_home/lib/libawt_xawt.so ]]; then
  echo "spy.sh: lcm-spy needs packages; run this line, then start again:" >&2
  echo "sudo apt-get update && sudo apt-get install -y liblcm-java libjchart2d-java default-jre" >&2
  exit 2
fi
exec java -Djava.net.preferIPv4Stack=true -cp "$classpath$(IFS=: && echo "${jars[*]}")" lcm.spy.Spy -l "$url"
