!> gracecg level1 prepare: a span of Level-1 files as an observation set.
module gracecg_level1_command_prepare
    use gracecg_base_version, only: VERSION
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_files_file, only: file_exists, read_text_file, text_file_t
    use gracecg_files_run_record, only: note_file, UPDATED
    use gracecg_observations_observation_files, only: write_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_preparation, only: prepare_observations
    use gracecg_level1_command_estimate, only: declare_data_options, take_calibration, MOST_PLACES, PLACES_ARE
    use gracecg_cli_work
    implicit none
    private
    public :: declare_level1_prepare, run_level1_prepare

    integer, parameter :: MOST_SPANS = 1000

contains

    !> Arguments and help of `gracecg level1 prepare`.
    subroutine declare_level1_prepare(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 prepare', 'PLACE ...', 1, MOST_PLACES, &
                                'Makes an observation set, as `gracecg estimate` takes it, of one span of Level-1 files: '// &
                                'GPS time, SRF axes, the field of the model or the corrected magnetometer, the rods as '// &
                                'measured, with gains and delays as estimated (rods.csv). '//PLACES_ARE, &
                                'gracecg level1 prepare day --setup setup.nml --number 2 --out span2')
        call declare_data_options(arguments)
        call arguments%add_option('--number', 'N', 'of the span that is wanted', default='1')
        call arguments%add_option('--out', 'DIR', 'folder to write the set into', required=.true.)
    end subroutine declare_level1_prepare

    !> The work of `gracecg level1 prepare`.
    subroutine run_level1_prepare(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(observation_set_t) :: observations
        character(:), allocatable :: folder
        character(80) :: about(2)
        integer :: number

        call arguments%get('--number', number, misuse, low=1, high=MOST_SPANS)
        call arguments%get('--out', folder, misuse)
        if (allocated(misuse)) return
        call refuse_other_set(folder, error)
        if (.not. allocated(error)) call take_calibration(arguments, setup, calibration, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call refuse_if(number > size(calibration%spans), '--number '//integer_text(number)//': there are '// &
                       integer_text(size(calibration%spans))//' spans', misuse)
        if (allocated(misuse)) return
        call estimate_level1(calibration, setup, 'estimate', estimate, error)
        if (.not. allocated(error)) call prepare_observations(calibration, setup, estimate, number, observations, error)
        if (allocated(error)) return
        call console%warn_all([calibration%notes, estimate%findings])
        if (estimate%solutions(1)%leakage /= 'estimated') call console%warn('the spans do not determine the leakage of the '// &
            'rods: it is in the accelerations, and the sigma of an estimate leaves it out')
        about(1) = 'gracecg '//VERSION//' level1 prepare'
        about(2) = 'GRACE-'//calibration%satellite//', '//calibration%date//', span '//integer_text(number)
        call write_observations(folder, observations, about, error)
        if (.not. allocated(error)) call console%line('written: '//folder//' ('// &
            integer_text(size(observations%accelerometer_time))//' samples of the accelerometer)')
    end subroutine run_level1_prepare

    !> Fails when the folder has an observation set that this command did not write: it would be lost.
    subroutine refuse_other_set(folder, error)
        character(*), intent(in) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        character(:), allocatable :: path

        path = folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE))
        if (.not. file_exists(path)) return
        call note_file(path, UPDATED)       ! looked at, and then replaced
        call read_text_file(path, file, error)
        if (allocated(error)) return
        if (index(file%text, 'level1 prepare') == 0) call fail(error, folder//' holds an observation set that level1 '// &
            'prepare did not write, and would be lost: take another folder')
    end subroutine refuse_other_set
end module gracecg_level1_command_prepare
