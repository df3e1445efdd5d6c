!> From a case to files: the true arc and one noisy observation set, written while they are made, so that memory does
!> not grow with the arc's length.
module gracecg_simulation_simulation_files
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_time, only: time_tag
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_files_file, only: make_directory, remove_file
    use gracecg_spacecraft_torque_rods, only: moves_rods
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_observation_files, only: observation_writer_t, OBSERVATION_FILES
    use gracecg_simulation_accelerometer, only: pmc_acceleration_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, ATTITUDE, OMEGA
    use gracecg_simulation_operator_errors, only: operator_t
    use gracecg_simulation_simulator, only: simulator_t, flight_t, begin_flight, run_noise_t, begin_noise, &
        observe_piece, drawn_wave, disturbance_at, measure_rods, operator_of_run, PIECE_EPOCHS
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_simulation_satellite, only: satellite_t
    implicit none
    private
    public :: simulation_order_t, simulation_summary_t, simulate_into, TRUTH_FILE, full_scale_t, count_full_scale, &
        full_scale_warnings

    character(*), parameter :: TRUTH_FILE = 'truth.csv'     !! The true arc, beside OBSERVATION_FILES
    character(*), parameter :: COLUMNS = &
        'time_s,rx_m,ry_m,rz_m,vx_m_s,vy_m_s,vz_m_s,q1,q2,q3,q4,wx_rad_s,wy_rad_s,wz_rad_s,'// &
        'wdx_rad_s2,wdy_rad_s2,wdz_rad_s2,bx_tesla,by_tesla,bz_tesla,ngx_m_s2,ngy_m_s2,ngz_m_s2'

    !> What is to be simulated, and written.
    type :: simulation_order_t
        character(:), allocatable :: folder             !! For the files; is made if it is not there
        type(case_t) :: case                            !! What is simulated
        integer(i8) :: seed = 1                         !! Of the random numbers
        integer :: run = 1                              !! Names them, too
        real(dp) :: rods_interval = 0                   !! s, of the measured moments of the rods; 0: none, or
        !! at every epoch where the attitude is controlled, or torquers turn the satellite
        character(100), allocatable :: comments(:)      !! First lines of the setup, and for what tells of the truth
    end type simulation_order_t

    !> What was written.
    type :: simulation_summary_t
        integer :: rows(size(OBSERVATION_FILES) - 1) = 0    !! Of each of OBSERVATION_FILES but the setup
        type(string_t), allocatable :: warnings(:)          !! Of instruments at their full scale
        logical :: moves_rods = .false.                     !! Is there a manoeuvre, as the operator knows it?
    end type simulation_summary_t

    !> Samples that reach the full scale of their instrument.
    type :: full_scale_t
        integer :: accelerometer = 0, accelerometer_samples = 0     !! Of so many
        integer :: magnetometer = 0, magnetometer_samples = 0       !! Of so many
    end type full_scale_t

contains

    !> Writes TRUTH_FILE and the observation set of a run: those of `new_simulator` and `observe`, to the last digit.
    !>
    !> Fails as these do, and when a file cannot be written; then none of the files stands, or those of before still do.
    subroutine simulate_into(order, summary, error)
        type(simulation_order_t), intent(in) :: order
        type(simulation_summary_t), intent(out) :: summary
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: truth
        type(observation_writer_t) :: writer

        call make_directory(order%folder, error)
        if (.not. allocated(error)) call truth%open(truth_path(order), COLUMNS, order%comments, error)
        if (.not. allocated(error)) call writer%open(order%folder, error)
        if (.not. allocated(error)) call write_pieces(order, truth, writer, summary, error)
        call truth%discard()
        call writer%discard()
    end subroutine simulate_into

    subroutine write_pieces(order, truth, writer, summary, error)
        type(simulation_order_t), intent(in) :: order
        type(csv_writer_t), intent(inout) :: truth
        type(observation_writer_t), intent(inout) :: writer
        type(simulation_summary_t), intent(inout) :: summary
        type(error_t), allocatable, intent(out) :: error

        type(flight_t) :: flight
        type(simulator_t) :: simulator
        type(run_noise_t) :: noise
        type(operator_t) :: operator
        type(observation_set_t) :: observations     ! of a piece
        type(full_scale_t) :: full_scale

        call begin_flight(order%case, flight, simulator, error)
        if (.not. allocated(error)) call begin_noise(simulator, order%seed, order%run, noise, error)
        if (allocated(error)) return
        operator = operator_of_run(simulator%case, simulator%case%operator, order%seed, order%run)
        do
            call flight%go_on(PIECE_EPOCHS, simulator, error)
            if (.not. allocated(error)) call observe_piece(simulator, operator, noise, observations, error)
            if (allocated(error)) return
            call append_truth(truth, simulator, drawn_wave(simulator, order%seed, order%run))
            call writer%append(observations)
            call count_full_scale(order%case%satellite, observations, full_scale)
            if (simulator%arc%last == simulator%arc%steps) exit
        end do
        if (order%rods_interval > 0) then
            call measure_rods(simulator, order%rods_interval, observations, error)
        else if (order%case%control%acts .or. order%case%satellite%rods%direct) then
            call measure_rods(simulator, simulator%arc%interval, observations, error)
        end if
        if (.not. allocated(error)) call truth%commit(error)
        if (allocated(error)) return
        call writer%commit(observations%knowledge, order%comments, error)
        if (allocated(error)) call remove_file(truth_path(order))
        summary%rows = writer%rows
        summary%moves_rods = moves_rods(observations%knowledge%rods, observations%knowledge%duration)
        call full_scale_warnings(order%case%satellite, full_scale, summary%warnings)
    end subroutine write_pieces

    !> Writes every epoch of the arc, or of a piece of it those that the piece before did not have: position (m) and
    !> velocity (m/s) in the inertial frame, attitude (inertial to body), angular velocity (rad/s) and acceleration
    !> (rad/s^2), magnetic flux density (T) and non-gravitational acceleration (m/s^2), the last four in body axes.
    subroutine append_truth(file, simulator, wave)
        type(csv_writer_t), intent(inout) :: file   !! Open
        type(simulator_t), intent(in) :: simulator
        type(density_wave_t), intent(in) :: wave    !! The density wave of the run

        type(pmc_acceleration_t) :: acceleration
        integer :: k

        associate (arc => simulator%arc)
            do k = merge(0, arc%first + 1, arc%first == 0), arc%last
                acceleration = disturbance_at(simulator%case, arc, wave, k)
                associate (state => arc%state(:, k))
                    call file%row([time_tag(k, arc%interval), state(POSITION), state(VELOCITY), &
                                   state(ATTITUDE), state(OMEGA), arc%omega_dot(:, k), &
                                   arc%loads(k)%field, acceleration%non_gravitational])
                end associate
            end do
        end associate
    end subroutine append_truth

    pure function truth_path(order) result(path)
        type(simulation_order_t), intent(in) :: order
        character(len(order%folder) + 1 + len(TRUTH_FILE)) :: path

        path = order%folder//'/'//TRUTH_FILE
    end function truth_path

    !> Counts the samples of a set that reach the full scale of their instrument, with those counted before.
    pure subroutine count_full_scale(satellite, observations, found)
        type(satellite_t), intent(in) :: satellite
        type(observation_set_t), intent(in) :: observations     !! Of this satellite
        type(full_scale_t), intent(inout) :: found

        found%accelerometer = found%accelerometer + &
                              count(maxval(abs(observations%acceleration), 1) >= satellite%accelerometer%range)
        found%accelerometer_samples = found%accelerometer_samples + size(observations%acceleration, 2)
        found%magnetometer = found%magnetometer + count(maxval(abs(observations%field), 1) >= satellite%magnetometer%range)
        found%magnetometer_samples = found%magnetometer_samples + size(observations%field, 2)
    end subroutine count_full_scale

    !> A sentence for each instrument whose samples reach its full scale: cut off there where the instrument is
    !> `limited`, else beyond what it can measure.
    subroutine full_scale_warnings(satellite, found, warnings)
        type(satellite_t), intent(in) :: satellite
        type(full_scale_t), intent(in) :: found         !! Of its samples
        type(string_t), allocatable, intent(out) :: warnings(:)

        allocate (warnings(0))
        associate (a => satellite%accelerometer, m => satellite%magnetometer)
            call say('accelerometer', found%accelerometer, found%accelerometer_samples, a%limited, &
                     number_text(a%range)//' m/s^2')
            call say('magnetometer', found%magnetometer, found%magnetometer_samples, m%limited, &
                     number_text(m%range/NANOTESLA)//' nT')
        end associate

    contains

        subroutine say(name, n, samples, limited, range_text)
            character(*), intent(in) :: name, range_text
            integer, intent(in) :: n, samples
            logical, intent(in) :: limited

            character(:), allocatable :: what

            if (n == 0) return
            what = ' lie beyond its full scale of '//range_text//', which `limited` would cut off'
            if (limited) what = ' are cut off at its full scale of '//range_text
            call append(warnings, name//': '//integer_text(n)//' of '//integer_text(samples)//' samples'//what)
        end subroutine say
    end subroutine full_scale_warnings
end module gracecg_simulation_simulation_files
