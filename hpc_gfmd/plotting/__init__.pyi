from .maps import height_map as height_map
from .pictures import chosen_steps as chosen_steps
from .pictures import figures as figures
from .pictures import plot as plot
from .pictures import plot_result as plot_result
