!> The C interface: simulation, setups, observation sets, options. Documented in include/gracecg.h.
module gracecg_interface_observations
    use gracecg, only: dp, error_t, simulator_t, new_simulator, observe, observation_set_t, operator_knowledge_t, &
        check_observations, read_observations, write_observations, read_setup, setup_from_text, setup_text, &
        estimation_options_t, read_options, write_options, options_from_text, options_text, moment_series_t, &
        new_moment_series, take_measured_moments
    use gracecg_environment_time, only: time_tag
    use gracecg_estimation_options, only: OPTIONS_FILE
    use gracecg_files_file, only: file_exists
    use gracecg_observations_observation_files, only: OBSERVATION_FILES, SETUP_FILE
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_items, only: items_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE, STATUS_NO_MEMORY
    use gracecg_interface_general, only: refuse_handle
    use gracecg_interface_cases, only: case_object_t, is_text
    implicit none
    private
    public :: simulator_object_t, setup_object_t, observations_object_t, simulator_open, simulate, setup_open, setup_from
    public :: observations_create, observations_open, observations_write, options_replace

    !> A true arc behind a handle.
    type, extends(object_t) :: simulator_object_t
        type(simulator_t) :: simulator                  !! Of a case
        type(estimation_options_t) :: options           !! Of its case
    contains
        procedure :: tell => tell_simulator             !! Puts its items
    end type simulator_object_t

    !> A setup behind a handle.
    type, extends(object_t) :: setup_object_t
        type(operator_knowledge_t) :: knowledge         !! Of an operator
        type(estimation_options_t) :: options           !! Beside it
    contains
        procedure :: tell => tell_setup                 !! Puts its items
    end type setup_object_t

    !> Observations behind a handle, with how they are estimated.
    type, extends(object_t) :: observations_object_t
        type(observation_set_t) :: set                  !! The samples, and what the operator knows
        type(estimation_options_t) :: options           !! How to estimate from it
    contains
        procedure :: tell => tell_observations          !! Puts its items
    end type observations_object_t

contains

    !> The true arc of a case and what its star cameras see: once, for any number of runs.
    subroutine simulator_open(the_case, made, outcome)
        class(case_object_t), intent(in) :: the_case
        type(simulator_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call new_simulator(the_case%calibration%case, made%simulator, failure)
        made%options = the_case%calibration%options
        call outcome%take(failure)
    end subroutine simulator_open

    subroutine tell_simulator(self, items)
        class(simulator_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        integer :: k

        associate (arc => self%simulator%arc)
            call items%put('time', [(time_tag(k, arc%interval), k=0, arc%steps)])
            call items%put('state', arc%state)
            call items%put('angular_acceleration', arc%omega_dot)
            call items%put('flux_density', reshape([(arc%loads(k)%field, k=0, arc%steps)], [3, arc%steps + 1]))
            call items%put('non_gravitational', reshape([(arc%loads(k)%drag + arc%loads(k)%srp + arc%loads(k)%erp, &
                                                          k=0, arc%steps)], [3, arc%steps + 1]))
        end associate
    end subroutine tell_simulator

    !> An observation set with the random numbers of a seed and run: the same as `gracecg simulate` draws.
    subroutine simulate(simulator, seed, run, made, outcome)
        class(simulator_object_t), intent(in) :: simulator
        integer, intent(in) :: seed, run                !! Alone decide the random numbers
        type(observations_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        made%options = simulator%options
        call observe(simulator%simulator, seed, run, made%set, failure)
        call outcome%take(failure)
    end subroutine simulate

    !> What an operator knows: satellite, manoeuvre, instruments; and how to estimate. From a file setup.nml, with the options
    !> of a file options.nml beside it or else those in itself, or from the text of one.
    subroutine setup_open(source, made, outcome)
        character(*), intent(in) :: source              !! Path or text
        type(setup_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (is_text(source)) then
            call setup_from_text(source, 'text', made%knowledge, failure)
            if (.not. allocated(failure)) call options_from_text(source, 'text', made%options, failure, beside=.true.)
        else
            call read_setup(source, made%knowledge, failure)
            if (.not. allocated(failure)) call read_options_beside(source, made%options, failure)
        end if
        call outcome%take(failure)
    end subroutine setup_open

    !> The options that belong to a setup.nml: those of options.nml in its folder, else those in itself.
    subroutine read_options_beside(setup, options, error)
        character(*), intent(in) :: setup           !! Path of the setup.nml
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error

        associate (path => setup(:index(setup, '/', back=.true.))//OPTIONS_FILE)
            if (file_exists(path)) then
                call read_options(path, options, error)
            else
                call read_options(setup, options, error, beside=.true.)
            end if
        end associate
    end subroutine read_options_beside

    !> The setup of an observation set (or a setup itself); with moments (A m^2) measured along the rods x, y, z at times (s
    !> from the epoch) in place of those that were commanded.
    subroutine setup_from(object, count, time, moment, made, outcome)
        class(object_t), intent(in) :: object                       !! A setup or an observation set
        integer, intent(in) :: count                                !! Samples of the moments; 0: as they were commanded
        real(dp), intent(in), optional :: time(count)               !! s from the epoch
        real(dp), intent(in), optional :: moment(3, count)          !! Along the rods, A m^2
        type(setup_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(moment_series_t) :: series
        type(error_t), allocatable :: failure

        select type (object)
        type is (setup_object_t)
            made%knowledge = object%knowledge
            made%options = object%options
        type is (observations_object_t)
            made%knowledge = object%set%knowledge
            made%options = object%options
        class default
            call refuse_handle('setup or observation set', outcome)
        end select
        if (.not. outcome%good() .or. .not. (present(time) .and. present(moment)) .or. count == 0) return
        call new_moment_series(time, moment, series, failure, direct=made%knowledge%rods%direct)
        call outcome%take(failure, STATUS_BAD_VALUE)
        if (outcome%good()) call take_measured_moments(series, made%knowledge%rods)
    end subroutine setup_from

    subroutine tell_setup(self, items)
        class(setup_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        character(:), allocatable :: settings, options

        settings = ''
        options = ''
        if (items%asks('text')) call setup_text(self%knowledge, settings, items%failure)
        if (.not. allocated(items%failure)) call options_text(self%options, options, items%failure)
        call items%say('text', settings//new_line('a')//new_line('a')//options)
        call items%say('options', options)
    end subroutine tell_setup

    !> An observation set from arrays in memory, which are copied and checked.
    subroutine observations_create(setup, accelerometer_count, accelerometer_time, acceleration, star_camera_count, &
                                   star_camera_time, star_camera_head, quaternion, magnetometer_count, magnetometer_time, &
                                   flux_density, orbit_count, orbit_time, orbit_position, made, outcome)
        class(setup_object_t), intent(in) :: setup
        integer, intent(in) :: accelerometer_count, star_camera_count, magnetometer_count, orbit_count      !! Samples
        real(dp), intent(in), optional :: accelerometer_time(accelerometer_count)       !! s from the epoch
        real(dp), intent(in), optional :: acceleration(3, accelerometer_count)          !! Body axes, m/s^2
        real(dp), intent(in), optional :: star_camera_time(star_camera_count)           !! s from the epoch
        integer, intent(in), optional :: star_camera_head(star_camera_count)            !! 1 or 2
        real(dp), intent(in), optional :: quaternion(4, star_camera_count)              !! Inertial to camera
        real(dp), intent(in), optional :: magnetometer_time(magnetometer_count)         !! s from the epoch
        real(dp), intent(in), optional :: flux_density(3, magnetometer_count)           !! Body axes, T
        real(dp), intent(in), optional :: orbit_time(orbit_count)                       !! s from the epoch
        real(dp), intent(in), optional :: orbit_position(3, orbit_count)                !! Inertial, m
        type(observations_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        made%set%knowledge = setup%knowledge
        made%options = setup%options
        call copy(accelerometer_count, 3, accelerometer_time, acceleration, made%set%accelerometer_time, &
                  made%set%acceleration, outcome)
        call copy(star_camera_count, 4, star_camera_time, quaternion, made%set%star_camera_time, made%set%quaternion, outcome)
        call copy(magnetometer_count, 3, magnetometer_time, flux_density, made%set%magnetometer_time, made%set%field, outcome)
        if (orbit_count > 0) &
            call copy(orbit_count, 3, orbit_time, orbit_position, made%set%orbit_time, made%set%orbit_position, outcome)
        allocate (made%set%star_camera_head(star_camera_count), source=0)
        if (present(star_camera_head)) made%set%star_camera_head = star_camera_head
        if (.not. outcome%good()) return
        call check_observations(made%set, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine observations_create

    !> The samples of one instrument; memory for many of them may not be there.
    subroutine copy(n, components, times, values, own_times, own_values, outcome)
        integer, intent(in) :: n, components            !! Samples; numbers of each
        real(dp), intent(in), optional :: times(n), values(components, n)
        real(dp), allocatable, intent(out) :: own_times(:), own_values(:, :)
        type(outcome_t), intent(inout) :: outcome

        integer :: memory

        allocate (own_times(n), own_values(components, n), stat=memory)
        if (memory /= 0) call outcome%refuse(STATUS_NO_MEMORY, 'no memory for the samples')
        if (memory /= 0) return
        if (present(times)) own_times = times
        if (present(values)) own_values = values
    end subroutine copy

    !> An observation set from a folder as `gracecg simulate` writes it, with the options of its options.nml, or the defaults.
    subroutine observations_open(folder, made, outcome)
        character(*), intent(in) :: folder              !! As `gracecg simulate` writes it
        type(observations_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call read_observations(folder, made%set, failure)
        if (.not. allocated(failure)) &
            call read_options_beside(folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), made%options, failure)
        call outcome%take(failure)
    end subroutine observations_open

    subroutine tell_observations(self, items)
        class(observations_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        character(:), allocatable :: options
        integer :: positions

        associate (set => self%set)
            positions = 0
            if (allocated(set%orbit_time)) positions = size(set%orbit_time)
            call items%put('counts', real([size(set%accelerometer_time), size(set%star_camera_time), &
                                           size(set%magnetometer_time), positions], dp))
            call items%put('accelerometer_time', set%accelerometer_time)
            call items%put('acceleration', set%acceleration)
            call items%put('star_camera_time', set%star_camera_time)
            call items%put('star_camera_head', real(set%star_camera_head, dp))
            call items%put('quaternion', set%quaternion)
            call items%put('magnetometer_time', set%magnetometer_time)
            call items%put('flux_density', set%field)
            if (positions > 0) then
                call items%put('orbit_time', set%orbit_time)
                call items%put('orbit_position', set%orbit_position)
            else
                call items%put('orbit_time', [real(dp) ::])
                call items%put('orbit_position', [real(dp) ::])
            end if
        end associate
        options = ''
        if (items%asks('options')) call options_text(self%options, options, items%failure)
        call items%say('options', options)
    end subroutine tell_observations

    !> Writes an observation set and its options into a folder, which is made if it is not there.
    subroutine observations_write(observations, folder, outcome)
        class(observations_object_t), intent(in) :: observations
        character(*), intent(in) :: folder              !! Made if it is not there
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure
        character(1) :: no_comments(0)

        call write_observations(folder, observations%set, no_comments, failure)
        if (.not. allocated(failure)) &
            call write_options(folder//'/'//OPTIONS_FILE, observations%options, no_comments, failure)
        call outcome%take(failure)
    end subroutine observations_write

    !> Another object like this one, a case, setup or observation set, with the options of a text; what it does not say has its
    !> default.
    subroutine options_replace(object, text, changed, outcome)
        class(object_t), intent(in) :: object                   !! A case, setup or observation set
        character(*), intent(in) :: text                        !! Of a file of options
        class(object_t), pointer, intent(out) :: changed        !! A copy; not associated after a failure
        type(outcome_t), intent(inout) :: outcome

        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        integer :: memory

        changed => null()
        call options_from_text(text, 'text', options, failure)
        call outcome%take(failure)
        if (.not. outcome%good()) return
        allocate (changed, source=object, stat=memory)
        if (memory /= 0) then
            changed => null()
            call outcome%refuse(STATUS_NO_MEMORY, 'no memory for a new object')
            return
        end if
        select type (changed)
        class is (case_object_t)
            changed%calibration%options = options
        type is (setup_object_t)
            changed%options = options
        type is (observations_object_t)
            changed%options = options
        class default
            call refuse_handle('case, setup or observation set', outcome)
        end select
    end subroutine options_replace
end module gracecg_interface_observations
