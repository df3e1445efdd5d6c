"""python3 -m gracecg.pages RESULT.json PAGE.html"""
import sys

try:
    from . import make_page
except ModuleNotFoundError as missing:
    sys.exit(f'{missing}: pages take the packages of gracecg[pages], got by pip install "gracecg[pages]"')

if len(sys.argv) != 3:
    sys.exit(__doc__)
try:
    print(make_page(sys.argv[1], sys.argv[2]), end="")
except (OSError, ValueError) as error:
    sys.exit(str(error))
